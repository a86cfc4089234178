// What a point query knows of folds before it is asked: which beams may turn over, and how far a fold may lie
// from where the mesh has it.
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "methods/sliced_beams/point_query.h"

namespace dapple::methods::sliced_beams {

template <class Real>
PointQuery<Real>::PointQuery(const SheetCoverage<Real>& sheet, const BeamNeighbors& neighbors)
    : sheet_(sheet), neighbors_(neighbors) {
    if (sheet.pyramid().empty()) return;
    constexpr std::size_t kPart = 1 << 14;
    const std::size_t beams = sheet.triangles().size();
    std::vector<std::uint8_t> turns(beams);
    parallel_for(beams, kPart, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            turns[i] = may_turn_over(static_cast<std::uint32_t>(i)) ? 1 : 0;
    });
    may_fold_.resize(beams);
    parallel_for(beams, kPart, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            may_fold_[i] = turns[i];
            for (int edge = 0; edge < 3; ++edge) {
                const Neighbor neighbor = neighbors_.across(static_cast<std::uint32_t>(i), edge);
                if (neighbor.triangle != kNoBeam) may_fold_[i] |= turns[neighbor.triangle];
            }
        }
    });
    find_margins();
}

template <class Real>
void PointQuery<Real>::find_margins() {
    const BeamPyramid<Real>& pyramid = sheet_.pyramid();
    margins_.resize(pyramid.levels());
    for (std::uint32_t level = 0; level < margins_.size(); ++level) {
        const std::uint32_t columns = pyramid.columns(level);
        margins_[level].resize(static_cast<std::size_t>(pyramid.rows(level)) * columns);
        parallel_for(margins_[level].size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const NodeId node{level, static_cast<std::uint32_t>(i / columns),
                                  static_cast<std::uint32_t>(i % columns)};
                Margin& margin = margins_[level][i];
                if (level > 0) {
                    pyramid.visit_children(node, [&](NodeId child) {
                        margin.widen(margins_[child.level][pyramid.index(child)]);
                    });
                    continue;
                }
                for (const std::uint32_t beam : pyramid.beams(node)) {
                    if (beam == kNoBeam || !may_fold_[beam]) continue;
                    margin.widen(second_difference(beam));
                    for (int edge = 0; edge < 3; ++edge) {
                        const Neighbor neighbor = neighbors_.across(beam, edge);
                        if (neighbor.triangle != kNoBeam) margin.widen(second_difference(neighbor.triangle));
                    }
                }
            }
        });
    }
}

/// Whether the area of the beam's slices, a quadratic of depth, falls below a tenth of what it is at the
/// surface: slices along a plane that leans differ from those across the axis by far less.
template <class Real>
bool PointQuery<Real>::may_turn_over(std::uint32_t beam) const {
    const auto& sheet = sheet_.sheet();
    if (!(sheet.flux[beam] > 0)) return false;
    const glm::uvec3& corners = sheet_.triangles()[beam];
    const auto &p = sheet.rays[corners[0]], &q = sheet.rays[corners[1]], &r = sheet.rays[corners[2]];
    const Real nearest = sheet_.pyramid().nearest();
    const auto edge = [&](const auto& to, Real& a, Real& b, Real& slope_a, Real& slope_b) {
        slope_a = to.slope_a - p.slope_a;
        slope_b = to.slope_b - p.slope_b;
        a = to.a - p.a + nearest * slope_a;
        b = to.b - p.b + nearest * slope_b;
    };
    Real qa, qb, qsa, qsb, ra, rb, rsa, rsb;
    edge(q, qa, qb, qsa, qsb);
    edge(r, ra, rb, rsa, rsb);
    const Real c0 = qa * rb - ra * qb;
    const Real c1 = qa * rsb + qsa * rb - ra * qsb - rsa * qb;
    const Real c2 = qsa * rsb - rsa * qsb;
    const Real depth = Real(1.1) * (sheet_.pyramid().farthest() - nearest);
    const auto ratio = [&](Real d) { return (c0 + d * (c1 + d * c2)) / c0; };
    const Real turn = -c1 / (2 * c2);
    Real least = ratio(depth);
    if (turn > 0 && turn < depth) least = std::min(least, ratio(turn));
    return !(least > Real(0.1));
}

template <class Real>
typename PointQuery<Real>::Margin PointQuery<Real>::second_difference(std::uint32_t beam) const {
    const auto& rays = sheet_.sheet().rays;
    const glm::uvec3& corners = sheet_.triangles()[beam];
    Margin largest;
    for (int edge = 0; edge < 3; ++edge) {
        const Neighbor neighbor = neighbors_.across(beam, edge);
        if (neighbor.triangle == kNoBeam || !(sheet_.sheet().flux[neighbor.triangle] > 0)) continue;
        const auto &a = rays[corners[edge]], &b = rays[corners[(edge + 1) % 3]],
                   &c = rays[corners[(edge + 2) % 3]], &d = rays[neighbor.vertex];
        const auto size = [&](Real depth) {
            const Real x = (c.a + d.a - a.a - b.a) + depth * (c.slope_a + d.slope_a - a.slope_a - b.slope_a);
            const Real y = (c.b + d.b - a.b - b.b) + depth * (c.slope_b + d.slope_b - a.slope_b - b.slope_b);
            return std::sqrt(x * x + y * y);
        };
        largest.near = std::max(largest.near, size(sheet_.pyramid().nearest()));
        largest.far = std::max(largest.far, size(sheet_.pyramid().farthest()));
    }
    return largest;
}
template PointQuery<float>::PointQuery(const SheetCoverage<float>&, const BeamNeighbors&);
template void PointQuery<float>::find_margins();
template bool PointQuery<float>::may_turn_over(std::uint32_t) const;
template PointQuery<float>::Margin PointQuery<float>::second_difference(std::uint32_t) const;
template PointQuery<double>::PointQuery(const SheetCoverage<double>&, const BeamNeighbors&);
template void PointQuery<double>::find_margins();
template bool PointQuery<double>::may_turn_over(std::uint32_t) const;
template PointQuery<double>::Margin PointQuery<double>::second_difference(std::uint32_t) const;

}  // namespace dapple::methods::sliced_beams
