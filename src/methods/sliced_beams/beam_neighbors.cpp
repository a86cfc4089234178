#include "methods/sliced_beams/beam_neighbors.h"

#include <algorithm>

namespace dapple::methods::sliced_beams {

BeamNeighbors::BeamNeighbors(int rows, int columns, std::span<const glm::uvec3> triangles)
    : rows_(rows), columns_(columns) {
    if (rows > 0) return;
    struct Edge {
        std::uint64_t ends;  ///< the lower vertex above the higher one's 32 bits
        std::uint32_t triangle;
        int edge;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const std::uint64_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            edges.push_back({std::min(from, to) << 32 | std::max(from, to), t, k});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        return x.ends != y.ends ? x.ends < y.ends : x.triangle < y.triangle;
    });
    table_.resize(3 * triangles.size());
    for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
        const Edge &x = edges[i], &y = edges[i + 1];
        if (x.ends != y.ends) continue;
        // More than two triangles at an edge are paired as they come: such a mesh has no sides to tell apart.
        table_[std::size_t{3} * x.triangle + static_cast<std::size_t>(x.edge)] = {
            y.triangle, triangles[y.triangle][(y.edge + 2) % 3]};
        table_[std::size_t{3} * y.triangle + static_cast<std::size_t>(y.edge)] = {
            x.triangle, triangles[x.triangle][(x.edge + 2) % 3]};
        ++i;
    }
}

Neighbor BeamNeighbors::across_in_grid(std::uint32_t triangle, int edge) const {
    const std::int64_t cell = triangle / 2, cells = columns_ - 1;
    const std::int64_t row = cell / cells, column = cell % cells;
    const bool second = triangle % 2 != 0;
    // Corners of the first triangle of a cell: (0, 0), (1, 0), (0, 1) in rows and columns; of the second:
    // (0, 1), (1, 0), (1, 1).
    struct Step {
        std::int64_t cell_row, cell_column, vertex_row, vertex_column;
    };
    static constexpr Step kSteps[2][3] = {{{0, -1, 1, -1}, {0, 0, 1, 1}, {-1, 0, -1, 1}},
                                          {{0, 0, 0, 0}, {1, 0, 2, 0}, {0, 1, 0, 2}}};
    const Step& step = kSteps[second ? 1 : 0][edge];
    const std::int64_t other_row = row + step.cell_row, other_column = column + step.cell_column;
    if (other_row < 0 || other_row >= rows_ - 1 || other_column < 0 || other_column >= cells) return {};
    const std::int64_t other = 2 * (other_row * cells + other_column) + (second ? 0 : 1);
    return {static_cast<std::uint32_t>(other),
            static_cast<std::uint32_t>((row + step.vertex_row) * columns_ + column + step.vertex_column)};
}

}  // namespace dapple::methods::sliced_beams
