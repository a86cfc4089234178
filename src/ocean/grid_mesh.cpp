#include "ocean/grid_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "ocean/lattice.h"

namespace dapple::ocean {
void WaterExtremes::add(const WaterVertex& vertex) {
    height = std::max(height, std::abs(vertex.position.y));
    displacement_squared = std::max(displacement_squared, vertex.displacement_squared);
    folded += vertex.folded ? 1 : 0;
}

void WaterExtremes::add(const WaterExtremes& others) {
    height = std::max(height, others.height);
    displacement_squared = std::max(displacement_squared, others.displacement_squared);
    folded += others.folded;
}

void WaterExtremes::put(scene::WaterMesh& water) const {
    water.largest_height = height;
    water.largest_displacement = std::sqrt(displacement_squared);
    water.folded_vertices = folded;
}

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

    std::vector<WaterExtremes> extremes(rows);
    parallel_for(rows, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const double z =
                grid_coordinate(extent.center.y, extent.size.y, static_cast<int>(row), grid.rows - 1);
            for (std::size_t column = 0; column < columns; ++column) {
                const std::size_t v = row * columns + column;
                const double x = grid_coordinate(extent.center.x, extent.size.x, static_cast<int>(column),
                                                 grid.columns - 1);
                const WaterVertex vertex = water_vertex(
                    x, z, [&](Field field) { return grid[field][v]; }, choppiness);
                mesh.positions[v] = vertex.position;
                mesh.normals[v] = vertex.normal;
                extremes[row].add(vertex);
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
    for (std::size_t row = 1; row < rows; ++row) extremes[0].add(extremes[row]);
    extremes[0].put(water);
    return water;
}

}  // namespace dapple::ocean
