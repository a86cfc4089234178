#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "light/water_beams.h"
#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// A rectangle across the axis of a beam sheet, m.
template <class Real>
struct Box {
    Real low_a, high_a, low_b, high_b;
};
template <class Real>
inline bool overlap(const Box<Real>& x, const Box<Real>& y) {
    return x.low_a <= y.high_a && x.high_a >= y.low_a && x.low_b <= y.high_b && x.high_b >= y.low_b;
}

constexpr std::uint32_t kNoBeam = 0xffffffffu;

/// Min/max pyramid over the landing points of a beam sheet. The finest nodes are clusters of up to eight
/// beams: 2 x 2 cells of a grid, or eight of an indexed mesh in Morton order (then a single row). Landing
/// points are linear in depth, so that a node's bounds at two depths, joined by straight lines, bound it at
/// all depths between: its least coordinate is a concave function of depth, its largest a convex one.
template <class Real>
class BeamPyramid {
public:
    struct NodeId {
        std::uint32_t level, row, column;
    };
    /// What the beams of a node carry: flux, and flux times what tells the mean of their rays; and where they
    /// leave the water.
    struct Sums {
        Real flux = 0;                            ///< unit of BeamSheet::flux
        Real flux_a = 0, flux_b = 0;              ///< times BeamSheet::Ray, m
        Real flux_slope_a = 0, flux_slope_b = 0;  ///< m a m of depth
        Real flux_start = 0;                      ///< times the depth at which the beams leave the water, m
        Real flux_stretch = 0;                    ///< times the length of a way a m of depth

        /// m, depths between which the beams leave the water.
        Real first_start = std::numeric_limits<Real>::infinity();
        Real last_start = -std::numeric_limits<Real>::infinity();
        /// m, largest product of a cluster's size and its spread of slopes: by so much, times how far a plane
        /// leans, a beam's straight edges there may leave the bounds of its slices.
        Real bend = 0;
        glm::vec<3, Real> tinted{0, 0, 0};  ///< flux of each channel

        Sums& operator+=(const Sums& other) {
            bend = std::max(bend, other.bend);
            first_start = std::min(first_start, other.first_start);
            last_start = std::max(last_start, other.last_start);
            flux += other.flux;
            flux_a += other.flux_a;
            flux_b += other.flux_b;
            flux_slope_a += other.flux_slope_a;
            flux_slope_b += other.flux_slope_b;
            flux_start += other.flux_start;
            flux_stretch += other.flux_stretch;
            tinted += other.tinted;
            return *this;
        }
    };

    /// Bounds hold for depths in [nearest, farthest], m. The sheet must outlive the pyramid.
    BeamPyramid(const light::BeamSheet<Real>& sheet, std::span<const glm::uvec3> triangles, Real nearest,
                Real farthest);

    Real nearest() const { return nearest_; }
    Real farthest() const { return farthest_; }
    bool empty() const { return levels_.empty(); }
    NodeId root() const { return {static_cast<std::uint32_t>(levels_.size() - 1), 0, 0}; }
    /// Bounds over the depths [low, high] of the node's rays, and of its beams as landed on a plane that
    /// changes by `lean` m of depth a m across the axis; empty (low > high) where no beam of the node carries
    /// light.
    Box<Real> box(NodeId node, Real low, Real high, Real lean = 0) const;
    /// How many of a node's rays meet a plane from its front between the nearest and the farthest depth.
    /// Where all do, beams landed on it keep to the bounds of their slices, whatever it leans: between these
    /// depths the bounds are flat, so that they hold all of a triangle whose corners they hold.
    enum class Meets { none, some, all };
    Meets meets(NodeId node, const glm::vec<3, Real>& point, const glm::vec<3, Real>& normal) const;
    const Sums& sums(NodeId node) const { return levels_[node.level].sums[index(node)]; }
    bool dark(NodeId node) const { return !(levels_[node.level].sums[index(node)].flux > 0); }
    /// `visit(child)` for the up to four children of a node above the finest level, in a fixed order.
    template <class Visit>
    void visit_children(NodeId node, Visit&& visit) const {
        const Level& finer = levels_[node.level - 1];
        for (std::uint32_t r = 2 * node.row; r < std::min(finer.rows, 2 * node.row + 2); ++r)
            for (std::uint32_t c = 2 * node.column; c < std::min(finer.columns, 2 * node.column + 2); ++c)
                visit(NodeId{node.level - 1, r, c});
    }
    std::size_t levels() const { return levels_.size(); }
    /// Of a level, 0 the finest.
    std::uint32_t rows(std::size_t level) const { return levels_[level].rows; }
    std::uint32_t columns(std::size_t level) const { return levels_[level].columns; }
    /// Place of a node in its level, row by row.
    std::size_t index(NodeId node) const {
        return static_cast<std::size_t>(node.row) * levels_[node.level].columns + node.column;
    }
    /// Triangles of a finest node, kNoBeam where there are fewer; a fixed order.
    std::array<std::uint32_t, kClusterBeams> beams(NodeId node) const;

private:
    struct Ends {
        Box<Real> near, far;  ///< bounds at the two depths
    };
    struct Level {
        std::uint32_t rows = 0, columns = 0;
        std::vector<Ends> ends;
        std::vector<Sums> sums;
    };
    void order_indexed(std::span<const glm::uvec3> triangles);
    void build_finest(std::span<const glm::uvec3> triangles);
    Level coarser(const Level& finer) const;

    const light::BeamSheet<Real>& sheet_;
    Real nearest_, farthest_;
    Real steepest_ = 0;                 ///< largest slope along a or b
    std::vector<std::uint32_t> order_;  ///< of an indexed mesh's triangles
    std::vector<Level> levels_;         ///< finest first
};

extern template class BeamPyramid<float>;
extern template class BeamPyramid<double>;

}  // namespace dapple::methods::sliced_beams
