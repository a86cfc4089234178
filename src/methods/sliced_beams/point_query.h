#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "methods/sliced_beams/beam_neighbors.h"
#include "methods/sliced_beams/sheet_coverage.h"

namespace dapple::methods::sliced_beams {

/// A beam that covers a point.
template <class Real>
struct PointHit {
    std::uint32_t beam;
    int sign;         ///< of det J: -1 where the beam has turned over
    Real weights[3];  ///< barycentric coordinates of the point among the landed corners
    bool near_fold;   ///< the flag of this beam's own edges
};

/// What is told of a point as a pixel's data.
struct PointSummary {
    int count = 0;
    int sign = 0;       ///< sum of signs: +1 below an endless smooth sheet without occluders
    bool fold = false;  ///< the number of paths is not sure: a finer mesh may find two more or less
};

/// The light paths of one sheet to points, by exact predicates: a vertex has one landing point (rounded to
/// float, relative to the point), which all its beams share, so that the signs of their areas fit together
/// without gaps or overlaps.
///
/// A point is near a fold where it is nearer to a landed edge between beams of opposite sign than a sixth of
/// the largest second difference |c + d - a - b| of the landed corners c, d across an edge a, b of one of
/// these beams, as seen across the edge between them: the smooth map's fold lies that near. A summary takes a
/// point for near one, too, where more than 64 clusters of beams reach that far: the mesh is too coarse to
/// tell there.
template <class Real>
class PointQuery {
public:
    PointQuery(const SheetCoverage<Real>& sheet, const BeamNeighbors& neighbors);

    /// For points near each other, in world axes; u and v need only span the tangent plane. Thread-safe.
    void summarize(std::span<const Receiver<Real>> points, std::span<PointSummary> summaries) const;
    /// In a fixed order. `fold`: the point's flag, also by beams that do not cover it.
    std::vector<PointHit<Real>> hits(const Receiver<Real>& point, bool& fold) const;

private:
    using NodeId = typename BeamPyramid<Real>::NodeId;
    /// m, largest second difference at the pyramid's two depths, of beams that may fold and those beside
    /// them.
    struct Margin {
        Real near = 0, far = 0;

        void widen(const Margin& other) {
            near = std::max(near, other.near);
            far = std::max(far, other.far);
        }
    };
    /// How far from its landed edges a beam can have a fold's flag.
    struct Reach {
        Real low, high;               ///< depths, m
        Real lean;                    ///< of the steepest plane
        const Receiver<Real>* plane;  ///< on which all points lie; null: they share none
        Real stretch;                 ///< of lengths along the planes against those across the axis
    };
    struct FoundNode {
        NodeId node;
        Box<Real> covered, reached;  ///< by its beams and by their folds, at all the points' depths
    };
    Margin second_difference(std::uint32_t beam) const;
    bool may_turn_over(std::uint32_t beam) const;
    void find_margins();
    Reach reach(const Receiver<Real>& local) const;
    /// Where points can lie that the node's beams cover, and that they cover or flag.
    Box<Real> covered_box(NodeId node, const Reach& reach, Real lean) const;
    Box<Real> reached_box(NodeId node, const Reach& reach, Real lean) const;
    /// By how much of the points' planes' lean the node's bounds are to be widened.
    Real lean(NodeId node, const Reach& reach) const;
    /// `folds_found`: false where so many may flag the points that only those that may cover one are given.
    std::vector<FoundNode> find_nodes(std::span<const Receiver<Real>> locals, bool& folds_found) const;
    enum class Wanted {
        fold,        ///< only whether the point has a flag: done once it has
        hits,        ///< and the hits
        every_fold,  ///< and each hit's own flag
    };
    template <class Visit>
    void visit_hits(const Receiver<Real>& local, std::span<const FoundNode> nodes, Wanted wanted, bool& fold,
                    Visit&& visit) const;
    void count_on_plane(std::span<const Receiver<Real>> locals, std::span<const FoundNode> nodes,
                        std::span<PointSummary> summaries) const;
    int upright(const Receiver<Real>& local) const;
    bool near_fold(const Receiver<Real>& local, const LandingFrame<Real>& frame, std::uint32_t beam) const;

    const SheetCoverage<Real>& sheet_;
    const BeamNeighbors& neighbors_;
    std::vector<std::vector<Margin>> margins_;  ///< beside the pyramid's levels
    /// 1 where the beam or one beside it comes near to turning over between the pyramid's depths: only such
    /// edges are looked at.
    std::vector<std::uint8_t> may_fold_;
};

extern template class PointQuery<float>;
extern template class PointQuery<double>;

}  // namespace dapple::methods::sliced_beams
