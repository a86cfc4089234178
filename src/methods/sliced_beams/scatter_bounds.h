#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/sliced_beams/beam_pyramid.h"
#include "methods/sliced_beams/landing.h"

namespace dapple::methods::sliced_beams {

/// Camera segments, one a lane, in a sheet's axes, m.
template <class Real>
struct SegmentLanes {
    Lanes<Real> a, b, depth;           ///< of the near end
    Lanes<Real> to_a, to_b, to_depth;  ///< unit
    Lanes<Real> length;                ///< where it ends; < 0: no segment
    Lanes<Real> first{};               ///< where what matters of it begins
};

/// Bounds of a pyramid's nodes for segments that cross many depths. Depth is cut into slabs; within one the
/// bounds of a node are linear in depth, so that with a segment, which is so too, they leave an interval.
/// Below the last of the pyramid's depths bounds grow as the steepest of the node's rays do: they hold for
/// segments of any depth.
template <class Real>
class ScatterBounds {
public:
    using NodeId = typename BeamPyramid<Real>::NodeId;

    /// `stops`: depth beyond which a beam has no light, one each, or none at all. All references outlive
    /// this.
    ScatterBounds(const light::BeamSheet<Real>& sheet, const BeamPyramid<Real>& pyramid,
                  std::span<const glm::uvec3> triangles, std::span<const Real> stops);

    /// Calls `visit(node, from, to)` for the clusters that may hold some of the segments, in a fixed order,
    /// with the intervals of [0, length] on which they may, m (from > to where not). `shift`: m a m of way,
    /// by which all rays lean further from where they leave the water.
    template <class Visit>
    void visit(const SegmentLanes<Real>& segments, glm::vec<2, Real> shift, Visit&& visit) const;

    static double nodes_a_cluster() { return 4.0 / 3 * (kSlabs + 1); }
    static double bytes_a_cluster() { return sizeof(Node) * nodes_a_cluster(); }

    /// Leaves out the clusters that hold nothing any more, by their index in the finest level: 1 a cluster.
    void leave_out(std::vector<std::uint8_t> clusters);

    /// Bounds at a slab's first depth, and by how much they grow, m a m.
    struct Node {
        Real low_a, high_a, low_b, high_b;
        Real low_grows_a, high_grows_a, low_grows_b, high_grows_b;
        Real first_start, last_start, stop;
    };
    struct Slab {
        Real from, to;                          ///< m of depth; the last one's end is infinite
        std::vector<std::vector<Node>> levels;  ///< as the pyramid's; dark nodes stop at -infinity
    };
    const std::vector<Slab>& slabs() const { return slabs_; }
    /// m, of all bounds' places at the last slab's first depth.
    Real largest() const { return largest_; }

private:
    static constexpr int kSlabs = 4;
    void build(Slab& slab, std::span<const glm::uvec3> triangles, std::span<const Real> stops) const;
    static Node united(const Node& x, const Node& y, Real height);

    const light::BeamSheet<Real>& sheet_;
    const BeamPyramid<Real>& pyramid_;
    Real largest_ = 0;
    std::vector<Slab> slabs_;
    std::vector<std::vector<std::uint8_t>> left_out_;  ///< a node of each level, or empty: none is
};

/// What is left of [from, to] beyond a place: where `rising` what follows it.
template <class Real, class AnyMask>
inline void clip_at(const Lanes<Real>& place, const AnyMask& rising, Lanes<Real>& from, Lanes<Real>& to) {
    constexpr Real infinity = std::numeric_limits<Real>::infinity();
    from = greater(rising ? place : splat(-infinity), from);
    to = lesser(rising ? splat(infinity) : place, to);
}

/// What is left of [from, to] where c0 + c1 s >= 0.
template <class Real>
inline void clip(Lanes<Real> c0, Lanes<Real> c1, Lanes<Real>& from, Lanes<Real>& to) {
    c1 += Lanes<Real>{};  // no -0, whose quotient would have the wrong sign
    clip_at<Real>(-c0 / c1, c1 >= 0, from, to);
}

template <class Real>
template <class Visit>
void ScatterBounds<Real>::visit(const SegmentLanes<Real>& s, glm::vec<2, Real> shift, Visit&& visit) const {
    using L = Lanes<Real>;
    struct Open {
        NodeId node;
        L from, to;
    };
    // Rounding of places; a few times more than can be.
    const L reach = magnitude(s.a) + magnitude(s.b) + magnitude(s.depth) + s.length + largest_;
    const L room = Real(8) * std::numeric_limits<Real>::epsilon() * reach;
    const L inverse_depth = Real(1) / (s.to_depth + L{});
    std::array<Open, 3 * 32 + 1> open;  // a node of each level is parted, into four at most
    std::size_t left = 0;
    for (const Slab& slab : slabs_) {
        // Slabs join without overlap: both get the same number for the place between them.
        const L at_from = (slab.from - s.depth) / s.to_depth, at_to = (slab.to - s.depth) / s.to_depth;
        const auto level = s.to_depth == 0;
        const auto within = (s.depth >= slab.from) & (s.depth < slab.to);
        const auto down = s.to_depth > 0;
        L first = greater(down ? at_from : at_to, s.first);
        L last = lesser(down ? at_to : at_from, s.length);
        first = level ? s.first : first;
        last = level ? (within ? s.length : splat(Real(-1))) : last;
        if (!any(first <= last)) continue;
        open[left++] = {pyramid_.root(), first, last};
        while (left > 0) {
            const NodeId id = open[--left].node;
            L from = open[left].from, to = open[left].to;
            if (!left_out_.empty() && left_out_[id.level][pyramid_.index(id)]) continue;
            const Node& n = slab.levels[id.level][pyramid_.index(id)];
            if (!(n.stop > slab.from)) continue;
            const L below = s.depth - slab.from;
            // The shift, times the depth from where the rays start.
            const Real start_a = std::max(shift.x * n.first_start, shift.x * n.last_start);
            const Real start_b = std::max(shift.y * n.first_start, shift.y * n.last_start);
            const Real end_a = std::min(shift.x * n.first_start, shift.x * n.last_start);
            const Real end_b = std::min(shift.y * n.first_start, shift.y * n.last_start);
            const auto above_low = [&](L at, L moves, Real low, Real grows, Real lean, Real start) {
                clip<Real>(at - (low - start) - below * grows - s.depth * lean + room,
                           moves - s.to_depth * (grows + lean), from, to);
            };
            const auto below_high = [&](L at, L moves, Real high, Real grows, Real lean, Real start) {
                clip<Real>((high - start) + below * grows + s.depth * lean - at + room,
                           s.to_depth * (grows + lean) - moves, from, to);
            };
            above_low(s.a, s.to_a, n.low_a, n.low_grows_a, shift.x, start_a);
            below_high(s.a, s.to_a, n.high_a, n.high_grows_a, shift.x, end_a);
            if (!any(from <= to)) continue;
            above_low(s.b, s.to_b, n.low_b, n.low_grows_b, shift.y, start_b);
            below_high(s.b, s.to_b, n.high_b, n.high_grows_b, shift.y, end_b);
            clip_at<Real>((n.first_start - s.depth - room) * inverse_depth, s.to_depth >= 0, from, to);
            clip_at<Real>((n.stop - s.depth + room) * inverse_depth, s.to_depth < 0, from, to);
            if (!any(from <= to)) continue;
            if (id.level == 0)
                visit(id, from, to);
            else
                pyramid_.visit_children(id, [&](NodeId child) {
                    __builtin_prefetch(&slab.levels[child.level][pyramid_.index(child)]);
                    open[left++] = {child, from, to};
                });
        }
    }
}

extern template class ScatterBounds<float>;
extern template class ScatterBounds<double>;

}  // namespace dapple::methods::sliced_beams
