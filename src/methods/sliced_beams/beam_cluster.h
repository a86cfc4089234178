#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "methods/sliced_beams/beam_slices.h"
#include "methods/sliced_beams/beam_ways.h"

namespace dapple::methods::sliced_beams {

/// The beams of one of a pyramid's clusters that carry light, and the vertices and edges that they share.
template <class Real>
struct BeamCluster {
    static constexpr int kMost = 3 * kClusterBeams;  ///< of vertices and edges: where beams share none
    struct Edge {
        std::uint8_t from, to;  ///< index into `ray`
    };
    struct Beam {
        std::uint32_t triangle;
        std::uint8_t corner[3];  ///< index into `ray`
        std::uint8_t edge[3];    ///< index into `edge`, of the one that faces a corner
        std::uint8_t turned[3];  ///< 1 where the edge runs the other way about the beam
        std::uint8_t shade;      ///< BeamWays::Shade
    };

    BeamCorner<Real> ray[kMost];  ///< a vertex
    Edge edge[kMost];
    Beam beam[kClusterBeams];
    std::uint8_t vertices = 0, edges = 0, beams = 0;
    Real first_start = std::numeric_limits<Real>::infinity();  ///< m, no beam leaves the water before
    Real last_start = -std::numeric_limits<Real>::infinity();  ///< m, all beams have left the water by there
    Real first_stop = std::numeric_limits<Real>::infinity();   ///< m, no beam is cut by an object before
    Real least_stretch = std::numeric_limits<Real>::infinity(), most_stretch = 0;  ///< m of way a m of depth

    /// Asks for the parts that most clusters fill.
    void prefetch() const {
        const auto lines = [](const auto* first, std::size_t count) {
            const auto* const bytes = reinterpret_cast<const char*>(first);
            for (std::size_t at = 0; at < count * sizeof(*first); at += 64) __builtin_prefetch(bytes + at);
        };
        lines(ray, 9);
        lines(edge, 16);
        lines(beam, kClusterBeams);
        lines(&vertices, 1);
    }

    /// Its rays, turned by `shift`, m a m of depth from where they leave the water.
    void corners(glm::vec<2, Real> shift, BeamCorner<Real> (&corner)[kMost]) const {
        for (int k = 0; k < vertices; ++k)
            corner[k] = {ray[k].a - ray[k].start * shift.x, ray[k].b - ray[k].start * shift.y,
                         ray[k].slope_a + shift.x, ray[k].slope_b + shift.y, ray[k].start};
    }
};

/// Of all finest nodes of a sheet's pyramid, in their order.
template <class Real>
std::vector<BeamCluster<Real>> beam_clusters(const SheetCoverage<Real>& sheet, const BeamWays<Real>& ways);

extern template std::vector<BeamCluster<float>> beam_clusters(const SheetCoverage<float>&,
                                                              const BeamWays<float>&);
extern template std::vector<BeamCluster<double>> beam_clusters(const SheetCoverage<double>&,
                                                               const BeamWays<double>&);

/// A cluster's beams against parts of segments: what slices() and visit_pieces() find of each beam, but what
/// beams share is found once.
template <class Real>
class ClusterSlices {
public:
    using L = Lanes<Real>;
    using Cluster = BeamCluster<Real>;

    /// `corner`: the rays of the cluster's vertices. Lanes that are not wanted may hold anything finite. The
    /// references outlive what is asked of this.
    void find(const Cluster& cluster, const BeamCorner<Real>* corner, const SegmentParts<Real>& part,
              const Mask<Real>& wanted);

    /// Calls `visit(beam, enter, leave, mask)` for the pieces of [-1, 1] that lie in a beam, index into
    /// BeamCluster::beam, beam by beam.
    template <class Visit>
    void visit_pieces(Visit&& visit) const;

    BeamSlices<Real> slices(int beam) const;
    /// Of slices(), the edge that faces a corner, but for its sign.
    const Quadratic<Real>& edge(int beam, int corner) const {
        return edge_[cluster_->beam[beam].edge[corner]];
    }
    Quadratic<Real> area(int beam) const {
        const auto& corner = cluster_->beam[beam].corner;
        return beam_area(corner_[corner[0]], corner_[corner[1]], corner_[corner[2]], part_);
    }

private:
    using Places = L[Cluster::kMost];
    void perturb(int edge, const Places& x0, const Places& y0, const Places& x1, const Places& y1);

    const Cluster* cluster_ = nullptr;
    const BeamCorner<Real>* corner_ = nullptr;
    SegmentParts<Real> part_;
    Mask<Real> wanted_;
    bool bends_ = false;  ///< some edge is crossed twice
    Quadratic<Real> edge_[Cluster::kMost];
    /// Where the segments come to lie on an edge's positive side [0] and leave it, and on its negative side
    /// [1]; enter > leave where they do not. Not where they cross it twice.
    Places enter_[2], leave_[2];
    Mask<Real> twice_[Cluster::kMost];
};

template <class Real>
void ClusterSlices<Real>::perturb(int e, const Places& x0, const Places& y0, const Places& x1,
                                  const Places& y1) {
    Quadratic<Real>& q = edge_[e];
    const int i = cluster_->edge[e].from, j = cluster_->edge[e].to;
    q.c0 = off_edge<Real>(q, x0[j] - x0[i] + (x1[j] - x1[i]), y0[j] - y0[i] + (y1[j] - y1[i]));
}

template <class Real>
void ClusterSlices<Real>::find(const Cluster& cluster, const BeamCorner<Real>* corner,
                               const SegmentParts<Real>& part, const Mask<Real>& wanted) {
    cluster_ = &cluster;
    corner_ = corner;
    part_ = part;
    wanted_ = wanted;
    bends_ = false;
    Places x0, y0, x1, y1;
    for (int v = 0; v < cluster.vertices; ++v) place(corner[v], part, x0[v], y0[v], x1[v], y1[v]);
    const L one = splat(Real(1)), never = splat(Real(2));
    for (int e = 0; e < cluster.edges; ++e) {
        const int i = cluster.edge[e].from, j = cluster.edge[e].to;
        Quadratic<Real>& q = edge_[e];
        q = beside(x0[i], y0[i], x1[i], y1[i], x0[i] - x0[j], y0[j] - y0[i], x1[i] - x1[j], y1[j] - y1[i]);
        if (any(wanted & (q.c0 == 0))) perturb(e, x0, y0, x1, y1);
        const L even = q.c0 + q.c2;
        const Mask<Real> first = even - q.c1 > 0, last = even + q.c1 > 0;
        const Mask<Real> crossed = first ^ last;
        twice_[e] = wanted & ~crossed & (magnitude(q.c1) < Real(2) * magnitude(q.c2));
        if (any(twice_[e])) {
            twice_[e] &= q.c1 * q.c1 >= Real(4) * q.c0 * q.c2;
            bends_ |= any(twice_[e]);
        }
        if (any(wanted & crossed)) {
            // The smaller root, which is the only one within.
            const L discriminant = greater(q.c1 * q.c1 - Real(4) * q.c0 * q.c2, L{});
            const L root = square_root<Real>(discriminant);
            const L at = Real(-2) * q.c0 / (q.c1 + (q.c1 < 0 ? -root : root));
            const L cut = lesser(greater(at, -one), one);
            enter_[0][e] = first ? -one : (last ? cut : never);
            leave_[0][e] = last ? one : (first ? cut : -never);
            enter_[1][e] = first ? (last ? never : cut) : -one;
            leave_[1][e] = last ? (first ? -never : cut) : one;
        } else {
            enter_[0][e] = first ? -one : never;
            leave_[0][e] = first ? one : -never;
            enter_[1][e] = first ? never : -one;
            leave_[1][e] = first ? -never : one;
        }
    }
}

template <class Real>
template <class Visit>
void ClusterSlices<Real>::visit_pieces(Visit&& visit) const {
    for (int i = 0; i < cluster_->beams; ++i) {
        const typename Cluster::Beam& beam = cluster_->beam[i];
        Mask<Real> once = wanted_;
        if (bends_) {
            const Mask<Real> twice = twice_[beam.edge[0]] | twice_[beam.edge[1]] | twice_[beam.edge[2]];
            once &= ~twice;
            if (any(twice))
                sliced_beams::visit_pieces(slices(i), twice,
                                           [&](const L& enter, const L& leave, const Mask<Real>& mask) {
                                               visit(i, enter, leave, mask);
                                           });
        }
        for (int side = 0; side < 2; ++side) {
            const auto of = [&](const Places(&place)[2], int k) {
                return place[side ^ beam.turned[k]][beam.edge[k]];
            };
            const L enter = greater(greater(of(enter_, 0), of(enter_, 1)), of(enter_, 2));
            const L leave = lesser(lesser(of(leave_, 0), of(leave_, 1)), of(leave_, 2));
            const Mask<Real> mask = once & (enter < leave);
            if (any(mask)) visit(i, enter, leave, mask);
        }
    }
}

template <class Real>
BeamSlices<Real> ClusterSlices<Real>::slices(int i) const {
    const typename Cluster::Beam& beam = cluster_->beam[i];
    BeamSlices<Real> result;
    for (int k = 0; k < 3; ++k) {
        const Quadratic<Real>& q = edge_[beam.edge[k]];
        const Real sign = beam.turned[k] ? Real(-1) : Real(1);
        result.edge[k] = {sign * q.c0, sign * q.c1, sign * q.c2};
    }
    result.area = area(i);
    return result;
}

}  // namespace dapple::methods::sliced_beams
