#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <unordered_map>
#include <vector>

namespace dapple::methods::adaptive_beams {

/// The hierarchical grid over a light's view (Liktor and Dachsbacher 2011, 4.1): `cells` x `cells` squares
/// of two triangles each, which are split where edges are marked. All triangles are right-angled and have two
/// equal sides; a split cuts the longest edge first (newest-vertex bisection, Mitchell 1991), so that no
/// triangle ever becomes thinner, and an edge is cut for both its triangles, so that there is no crack.
/// Triangles may be discarded; those beside them then have an edge that no other triangle has. Vertices lie
/// on a lattice of whole numbers. All orders are fixed.
class ProjectedGrid {
public:
    struct Edge {
        std::array<std::uint32_t, 2> vertices;   ///< ascending
        std::array<std::uint32_t, 2> triangles;  ///< the second kNone at a border
    };
    struct Triangle {
        std::array<std::uint32_t, 3> vertices;  ///< the longest edge is between the first two
        std::array<std::uint32_t, 3> edges;     ///< from vertex i to i + 1
    };
    static constexpr std::uint32_t kNone = 0xffffffffu;

    /// `levels`: how often split() may be called.
    ProjectedGrid(int cells, int levels);

    /// (u, v) of a vertex.
    glm::dvec2 uv(std::uint32_t vertex) const { return glm::dvec2(points_[vertex]) * step_; }
    std::size_t vertices() const { return points_.size(); }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const std::vector<Edge>& edges() const { return edges_; }
    /// The vertex in the middle of an edge, which is made where there is none yet; a later split uses it.
    /// Only while there are levels left.
    std::uint32_t middle(std::uint32_t edge);

    /// Leaves out the triangles that are discarded (an entry a triangle, not 0: it is; no entries: none is),
    /// then cuts the marked edges (an entry an edge, not 0: marked), and the longest edge of every triangle
    /// that has a marked one, once. False, and nothing is changed, if there would be more than `most`
    /// triangles.
    bool split(std::span<const std::uint8_t> marked, std::size_t most = kNone,
               std::span<const std::uint8_t> discarded = {});

private:
    std::uint32_t vertex(glm::ivec2 point);
    void connect();
    void bisect(std::array<std::uint32_t, 3> vertices, std::array<std::uint32_t, 3> middles,
                std::vector<Triangle>& cut) const;

    double step_;
    std::vector<glm::ivec2> points_;
    std::unordered_map<std::uint64_t, std::uint32_t> index_;
    std::vector<Triangle> triangles_;
    std::vector<Edge> edges_;
};

}  // namespace dapple::methods::adaptive_beams
