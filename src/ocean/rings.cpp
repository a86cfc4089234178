#include "ocean/rings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "ocean/grid_mesh.h"

namespace dapple::ocean {
namespace {

/// One level in a frame.
struct Level {
    Lattice lattice;
    std::size_t first_vertex = 0;
};

std::size_t vertices_of(const CellBox& box) {
    if (box.empty()) return 0;
    return static_cast<std::size_t>(box.cells().x + 1) * static_cast<std::size_t>(box.cells().y + 1);
}

class RingMesh {
public:
    RingMesh(const RingLayout& rings, const LinearWaves& waves, double choppiness, double time,
             glm::dvec2 viewpoint)
        : rings_(rings),
          waves_(waves),
          choppiness_(choppiness),
          mask_(mesh_fields(choppiness)),
          wanted_(fields_of(mask_)),
          time_(time),
          viewpoint_(viewpoint) {
        for (int l = 0; l < rings.levels(); ++l) levels_.push_back({rings.lattice(l, viewpoint)});
    }

    scene::WaterMesh make() {
        std::size_t vertices = 0, triangles = 0;
        for (Level& level : levels_) {
            level.first_vertex = vertices;
            vertices += vertices_of(level.lattice.box) - vertices_of(level.lattice.hole);
        }
        mesh_.positions.resize(vertices);
        mesh_.normals.resize(vertices);
        for (int l = 0; l < rings_.levels(); ++l) {
            if (level(l).lattice.box.empty()) continue;
            place_vertices(l);
            triangles = place_triangles(l, triangles);
        }
        water_.one_sheet = true;
        extremes_.put(water_);
        const double all = waves_.mean_square_slope({});
        for (int l = 0; l < rings_.levels(); ++l) {
            const glm::dvec2 cell = rings_.cell(l);
            const bool last = l + 1 == rings_.levels();
            const glm::dvec2 size = last ? level(l).lattice.extent.size : cell * double(rings_.across());
            const double kept =
                waves_.mean_square_slope(last ? rings_.last_waves(l) : rings_.lasting_waves(l));
            water_.rings.push_back(
                {std::max(cell.x, cell.y), std::max(size.x, size.y), all > 0 ? 1 - kept / all : 0});
        }
        return std::move(water_);
    }

private:
    Level& level(int l) { return levels_[static_cast<std::size_t>(l)]; }
    const Level& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

    /// Of a level's vertex, which may belong to the level inside it.
    std::uint32_t index(int l, glm::ivec2 vertex) const {
        const Level& of = level(l);
        const CellBox &box = of.lattice.box, &hole = of.lattice.hole;
        if (hole.holds(vertex)) return index(l - 1, 2 * vertex);
        const int row = vertex.y - box.lower.y;
        std::int64_t before = static_cast<std::int64_t>(row) * of.lattice.columns() + vertex.x - box.lower.x;
        if (!hole.empty()) {
            const std::int64_t width = hole.cells().x + 1;
            before -= width * std::clamp(vertex.y - hole.lower.y, 0, hole.cells().y + 1);
            if (vertex.y >= hole.lower.y && vertex.y <= hole.upper.y && vertex.x > hole.upper.x)
                before -= width;
        }
        return static_cast<std::uint32_t>(of.first_vertex + static_cast<std::size_t>(before));
    }

    /// Fields at the level's vertices, with the waves that go before its end by their weight, and morphed.
    SurfaceGrid fields(int l, const Lattice& lattice) const {
        SurfaceGrid grid = waves_.grid(lattice, time_, mask_, rings_.lasting_waves(l));
        const auto columns = static_cast<std::size_t>(lattice.columns());
        if (waves_.any(rings_.last_waves(l))) {
            const SurfaceGrid going = waves_.grid(lattice, time_, mask_, rings_.last_waves(l));
            for_vertices(lattice, [&](int row, int column) {
                const std::size_t v =
                    static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column);
                const double kept = 1 - morph(l, lattice, row, column);
                for (const Field field : wanted_) grid[field][v] += kept * going[field][v];
            });
        }
        // Vertices with an odd index take the mean of the two between which they lie on the next level's
        // triangles, which are split as these are: along the row, the column or the diagonal. Those have even
        // indices, and stay.
        for_vertices(lattice, [&](int row, int column) {
            const glm::ivec2 odd = (lattice.box.lower + glm::ivec2(column, row)) & 1;
            if (odd.x == 0 && odd.y == 0) return;
            const double weight = morph(l, lattice, row, column);
            if (!(weight > 0)) return;
            const auto at = [&](int r, int c) {
                return static_cast<std::size_t>(r) * columns + static_cast<std::size_t>(c);
            };
            const std::size_t v = at(row, column), a = at(row + odd.y, column - odd.x),
                              b = at(row - odd.y, column + odd.x);
            for (const Field field : wanted_) {
                const double mean = 0.5 * (grid[field][a] + grid[field][b]);
                grid[field][v] = weight < 1 ? (1 - weight) * grid[field][v] + weight * mean : mean;
            }
        });
        return grid;
    }

    double morph(int l, const Lattice& lattice, int row, int column) const {
        return rings_.morph(l, glm::dvec2(lattice.x(column), lattice.z(row)) - viewpoint_);
    }

    template <class Body>
    static void for_vertices(const Lattice& lattice, const Body& body) {
        parallel_for(static_cast<std::size_t>(lattice.rows()), 8, [&](std::size_t begin, std::size_t end) {
            for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
                lattice.for_runs(row, [&](int first, int last) {
                    for (int column = first; column < last; ++column) body(row, column);
                });
            }
        });
    }

    void place_vertices(int l) {
        const Lattice& lattice = level(l).lattice;
        const SurfaceGrid grid = fields(l, lattice);
        std::vector<WaterExtremes> extremes(static_cast<std::size_t>(lattice.rows()));
        for_vertices(lattice, [&](int row, int column) {
            const std::size_t v =
                static_cast<std::size_t>(row) * static_cast<std::size_t>(lattice.columns()) +
                static_cast<std::size_t>(column);
            const WaterVertex vertex = water_vertex(
                lattice.x(column), lattice.z(row), [&](Field field) { return grid[field][v]; }, choppiness_);
            const std::uint32_t to = index(l, lattice.box.lower + glm::ivec2(column, row));
            mesh_.positions[to] = vertex.position;
            mesh_.normals[to] = vertex.normal;
            extremes[static_cast<std::size_t>(row)].add(vertex);
        });
        for (const WaterExtremes& row : extremes) extremes_.add(row);
    }

    /// Of the row of cells from grid line `j` on.
    static std::size_t triangles_in_row(const Lattice& lattice, int j) {
        const CellBox &box = lattice.box, &hole = lattice.hole;
        int count = 2 * box.cells().x;
        if (hole.empty()) return static_cast<std::size_t>(count);
        if (j >= hole.lower.y && j < hole.upper.y)
            count += (hole.lower.x > box.lower.x) + (hole.upper.x < box.upper.x) - 2 * hole.cells().x;
        if (j + 1 == hole.lower.y || j == hole.upper.y) count += hole.cells().x;
        return static_cast<std::size_t>(count);
    }

    /// From triangle `first` on; returns the end. Where a cell's side runs along the hole it is two sides of
    /// the level inside, and the triangle there is cut in two, so that no vertex lies on another's edge.
    std::size_t place_triangles(int l, std::size_t first) {
        const Lattice& lattice = level(l).lattice;
        const CellBox box = lattice.box, hole = lattice.hole;
        const auto rows = static_cast<std::size_t>(box.cells().y);
        std::vector<std::size_t> starts(rows + 1, first);
        for (std::size_t row = 0; row < rows; ++row)
            starts[row + 1] = starts[row] + triangles_in_row(lattice, box.lower.y + static_cast<int>(row));
        mesh_.triangles.resize(starts.back());
        parallel_for(rows, 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                const int j = box.lower.y + static_cast<int>(row);
                glm::uvec3* triangle = mesh_.triangles.data() + starts[row];
                const bool beside = !hole.empty() && j >= hole.lower.y && j < hole.upper.y;
                for (int i = box.lower.x; i < box.upper.x; ++i) {
                    const bool within = !hole.empty() && i >= hole.lower.x && i < hole.upper.x;
                    if (beside && within) continue;
                    const glm::ivec2 a{i, j}, b{i + 1, j}, c{i, j + 1}, d{i + 1, j + 1};
                    const std::uint32_t at_a = index(l, a), at_b = index(l, b), at_c = index(l, c),
                                        at_d = index(l, d);
                    const auto middle = [&](glm::ivec2 p, glm::ivec2 q) { return index(l - 1, p + q); };
                    if (beside && i == hole.upper.x) {
                        const std::uint32_t m = middle(a, c);
                        *triangle++ = {at_a, m, at_b};
                        *triangle++ = {m, at_c, at_b};
                    } else if (within && j == hole.upper.y) {
                        const std::uint32_t m = middle(a, b);
                        *triangle++ = {at_a, at_c, m};
                        *triangle++ = {m, at_c, at_b};
                    } else {
                        *triangle++ = {at_a, at_c, at_b};
                    }
                    if (beside && i + 1 == hole.lower.x) {
                        const std::uint32_t m = middle(b, d);
                        *triangle++ = {at_b, at_c, m};
                        *triangle++ = {m, at_c, at_d};
                    } else if (within && j + 1 == hole.lower.y) {
                        const std::uint32_t m = middle(c, d);
                        *triangle++ = {at_b, at_c, m};
                        *triangle++ = {at_b, m, at_d};
                    } else {
                        *triangle++ = {at_b, at_c, at_d};
                    }
                }
            }
        });
        return starts.back();
    }

    const RingLayout& rings_;
    const LinearWaves& waves_;
    double choppiness_;
    FieldMask mask_;
    std::vector<Field> wanted_;
    double time_;
    glm::dvec2 viewpoint_;
    std::vector<Level> levels_;
    scene::WaterMesh water_;
    scene::TriangleMesh& mesh_ = water_.mesh;
    WaterExtremes extremes_;
};

}  // namespace

scene::WaterMesh ring_mesh(const RingLayout& rings, const LinearWaves& waves, double choppiness, double time,
                           glm::dvec2 viewpoint) {
    return RingMesh(rings, waves, choppiness, time, viewpoint).make();
}

}  // namespace dapple::ocean
