#include "ocean/grid_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"

namespace dapple::ocean {
namespace {

struct RowExtremes {
    double height = 0;
    double displacement_squared = 0;
    std::size_t folded = 0;
};

}  // namespace

scene::WaterMesh grid_mesh(const scene::Extent& extent, const SurfaceGrid& grid, double choppiness) {
    scene::WaterMesh water;
    water.rows = grid.rows;
    water.columns = grid.columns;
    const auto rows = static_cast<std::size_t>(grid.rows);
    const auto columns = static_cast<std::size_t>(grid.columns);
    scene::TriangleMesh& mesh = water.mesh;
    mesh.positions.resize(rows * columns);
    mesh.normals.resize(rows * columns);
    mesh.triangles.resize(2 * (rows - 1) * (columns - 1));

    const double* height = grid[Field::height].data();
    const double* slope_x = grid[Field::slope_x].data();
    const double* slope_z = grid[Field::slope_z].data();
    std::vector<RowExtremes> extremes(rows);
    parallel_for(rows, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            RowExtremes& extreme = extremes[row];
            const double z =
                grid_coordinate(extent.center.y, extent.size.y, static_cast<int>(row), grid.rows - 1);
            for (std::size_t column = 0; column < columns; ++column) {
                const std::size_t v = row * columns + column;
                const double x = grid_coordinate(extent.center.x, extent.size.x, static_cast<int>(column),
                                                 grid.columns - 1);
                glm::dvec3 position(x, height[v], z);
                glm::dvec3 normal(-slope_x[v], 1, -slope_z[v]);
                if (choppiness != 0) {
                    const double dx = choppiness * grid[Field::displacement_x][v];
                    const double dz = choppiness * grid[Field::displacement_z][v];
                    position.x += dx;
                    position.z += dz;
                    const double xx = choppiness * grid[Field::displacement_xx][v];
                    const double xz = choppiness * grid[Field::displacement_xz][v];
                    const double zz = choppiness * grid[Field::displacement_zz][v];
                    normal =
                        glm::cross(glm::dvec3(xz, slope_z[v], 1 + zz), glm::dvec3(1 + xx, slope_x[v], xz));
                    extreme.displacement_squared = std::max(extreme.displacement_squared, dx * dx + dz * dz);
                    // normal.y is the Jacobian of the horizontal map.
                    if (!(normal.y > 0)) ++extreme.folded;
                }
                mesh.positions[v] = position;
                mesh.normals[v] = normal * (1 / std::sqrt(glm::dot(normal, normal)));
                extreme.height = std::max(extreme.height, std::abs(position.y));
            }
            if (row + 1 == rows) continue;
            glm::uvec3* triangle = mesh.triangles.data() + 2 * row * (columns - 1);
            for (std::size_t column = 0; column + 1 < columns; ++column) {
                const auto near = static_cast<std::uint32_t>(row * columns + column);
                const auto far = static_cast<std::uint32_t>((row + 1) * columns + column);
                *triangle++ = {near, far, near + 1};
                *triangle++ = {near + 1, far, far + 1};
            }
        }
    });
    for (const RowExtremes& extreme : extremes) {
        water.largest_height = std::max(water.largest_height, extreme.height);
        water.largest_displacement =
            std::max(water.largest_displacement, std::sqrt(extreme.displacement_squared));
        water.folded_vertices += extreme.folded;
    }
    return water;
}

}  // namespace dapple::ocean
