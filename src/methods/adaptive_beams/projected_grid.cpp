#include "methods/adaptive_beams/projected_grid.h"

#include <algorithm>

namespace dapple::methods::adaptive_beams {

ProjectedGrid::ProjectedGrid(int cells, int levels)
    : step_(1.0 / (static_cast<double>(cells) * (1 << levels))) {
    const int size = 1 << levels;
    for (int row = 0; row <= cells; ++row)
        for (int column = 0; column <= cells; ++column) vertex(glm::ivec2(column, row) * size);
    const auto at = [&](int column, int row) {
        return static_cast<std::uint32_t>(row * (cells + 1) + column);
    };
    for (int row = 0; row < cells; ++row)
        for (int column = 0; column < cells; ++column) {
            // The diagonals of neighbours meet, as those of a square that was split do.
            const std::array<std::uint32_t, 4> corner = {at(column, row), at(column + 1, row),
                                                         at(column + 1, row + 1), at(column, row + 1)};
            const std::size_t first = (row + column) % 2 == 0 ? 0 : 1;
            const auto c = [&](std::size_t i) { return corner[(first + i) % 4]; };
            triangles_.push_back({{c(2), c(0), c(1)}, {}});
            triangles_.push_back({{c(0), c(2), c(3)}, {}});
        }
    connect();
}

std::uint32_t ProjectedGrid::vertex(glm::ivec2 point) {
    const std::uint64_t key = static_cast<std::uint64_t>(point.y) << 32 | static_cast<std::uint32_t>(point.x);
    const auto [found, inserted] = index_.try_emplace(key, static_cast<std::uint32_t>(points_.size()));
    if (inserted) points_.push_back(point);
    return found->second;
}

std::uint32_t ProjectedGrid::middle(std::uint32_t edge) {
    const Edge& e = edges_[edge];
    return vertex((points_[e.vertices[0]] + points_[e.vertices[1]]) / 2);
}

void ProjectedGrid::connect() {
    edges_.clear();
    std::unordered_map<std::uint64_t, std::uint32_t> known;
    known.reserve(2 * triangles_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] =
                std::minmax(triangles_[t].vertices[i], triangles_[t].vertices[(i + 1) % 3]);
            const auto [found, inserted] = known.try_emplace(static_cast<std::uint64_t>(low) << 32 | high,
                                                             static_cast<std::uint32_t>(edges_.size()));
            if (inserted) {
                edges_.push_back({{low, high}, {t, kNone}});
            } else {
                edges_[found->second].triangles[1] = t;
            }
            triangles_[t].edges[i] = found->second;
        }
}

/// `middles` are the vertices in the middle of the edges, kNone where an edge is not cut; where one is cut,
/// the longest is. The halves have the new vertex last, opposite their longest edge.
void ProjectedGrid::bisect(std::array<std::uint32_t, 3> v, std::array<std::uint32_t, 3> middles,
                           std::vector<Triangle>& cut) const {
    if (middles[0] == kNone) {
        cut.push_back({v, {}});
        return;
    }
    bisect({v[2], v[0], middles[0]}, {middles[2], kNone, kNone}, cut);
    bisect({v[1], v[2], middles[0]}, {middles[1], kNone, kNone}, cut);
}

bool ProjectedGrid::split(std::span<const std::uint8_t> marked, std::size_t most,
                          std::span<const std::uint8_t> discarded) {
    const auto stays = [&](std::uint32_t t) {
        return t != kNone && (discarded.empty() || discarded[t] == 0);
    };
    std::vector<std::uint8_t> marks(marked.begin(), marked.end());
    std::vector<std::uint32_t> pending;
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
        if (marks[e] != 0) pending.push_back(e);
    while (!pending.empty()) {
        const Edge& edge = edges_[pending.back()];
        pending.pop_back();
        for (const std::uint32_t t : edge.triangles) {
            if (!stays(t)) continue;
            const std::uint32_t longest = triangles_[t].edges[0];
            if (marks[longest] != 0) continue;
            marks[longest] = 1;
            pending.push_back(longest);
        }
    }
    std::size_t triangles = 0;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) triangles += stays(t) ? 1 : 0;
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
        for (const std::uint32_t t : edges_[e].triangles) triangles += marks[e] != 0 && stays(t) ? 1 : 0;
    if (triangles > most) return false;
    std::vector<std::uint32_t> middles(edges_.size(), kNone);
    for (std::uint32_t e = 0; e < edges_.size(); ++e)
        if (marks[e] != 0) middles[e] = middle(e);
    std::vector<Triangle> cut;
    cut.reserve(2 * triangles_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        if (!stays(t)) continue;
        const Triangle& triangle = triangles_[t];
        const auto of = [&](std::size_t i) { return middles[triangle.edges[i]]; };
        bisect(triangle.vertices, {of(0), of(1), of(2)}, cut);
    }
    triangles_ = std::move(cut);
    connect();
    return true;
}

}  // namespace dapple::methods::adaptive_beams
