#include "methods/sliced_beams/point_query.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "methods/sliced_beams/exact_side.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Of a second difference: how far a fold of the smooth map may lie from the mesh's. Linear interpolation
/// along an edge is off by an eighth at most; triangles are so along their edges only, so a little more (of
/// 46 points of 10^4 at which a mesh and interval Newton disagreed, all lay within 0.15).
constexpr double kFoldShare = 1.0 / 6;

/// Far past focus, where as many clusters as this may flag a point, its count is not sure in any case.
constexpr std::size_t kMostFoldClusters = 128;
/// The same of a tile of points.
constexpr std::size_t kMostFoldNodes = 2048;

/// To within the rounding of positions.
template <class Real>
bool on_one_plane(const Receiver<Real>& p, const Receiver<Real>& q) {
    constexpr Real rounding = Real(16) * std::numeric_limits<Real>::epsilon();
    const Real size = std::max({std::abs(q.position.x), std::abs(q.position.y), std::abs(q.position.z)});
    return p.normal == q.normal && std::abs(glm::dot(q.position - p.position, p.normal)) <= rounding * size;
}

/// Barycentric coordinates of the point among a beam's landed corners, and how far there it is past its
/// start.
template <class Real>
Real weigh(const Landed (&corner)[3], const LandedChunk<Real>& landed, int lane, Real (&weights)[3]) {
    Real past = 0, all = 0;
    for (int k = 0; k < 3; ++k) {
        const Landed &p = corner[(k + 1) % 3], &q = corner[(k + 2) % 3];
        weights[k] = static_cast<Real>(std::abs(static_cast<double>(p.x) * static_cast<double>(q.y) -
                                                static_cast<double>(q.x) * static_cast<double>(p.y)));
        all += weights[k];
    }
    for (int k = 0; k < 3; ++k) {
        weights[k] = all > 0 ? weights[k] / all : Real(1) / 3;
        past += weights[k] * landed.past_start[k][lane];
    }
    return past;
}

template <class Real>
bool lies_in_light(const Landed (&corner)[3], const LandedChunk<Real>& landed, int lane) {
    Real weights[3];
    return weigh(corner, landed, lane, weights) >= 0;
}

template <class Real>
Box<Real> point_box(const Receiver<Real>& r) {
    return {r.position.x, r.position.x, r.position.y, r.position.y};
}

}  // namespace

template <class Real>
typename PointQuery<Real>::Reach PointQuery<Real>::reach(const Receiver<Real>& local) const {
    return {local.position.z, local.position.z, sheet_.lean(local.normal), &local,
            1 / std::max(Real(0.1), std::abs(local.normal.z))};
}

/// 0 where all the node's beams land on the points' plane within the pyramid's depths.
template <class Real>
Real PointQuery<Real>::lean(NodeId node, const Reach& reach) const {
    using Pyramid = BeamPyramid<Real>;
    if (reach.lean == 0) return 0;
    const bool all = reach.plane && sheet_.pyramid().meets(node, reach.plane->position,
                                                           reach.plane->normal) == Pyramid::Meets::all;
    return all ? Real(0) : reach.lean;
}

template <class Real>
Box<Real> PointQuery<Real>::covered_box(NodeId node, const Reach& reach, Real lean) const {
    return sheet_.pyramid().box(node, reach.low, reach.high, lean);
}

template <class Real>
Box<Real> PointQuery<Real>::reached_box(NodeId node, const Reach& reach, Real lean) const {
    const BeamPyramid<Real>& pyramid = sheet_.pyramid();
    const Margin& margin = margins_[node.level][pyramid.index(node)];
    const Real range = pyramid.farthest() - pyramid.nearest();
    // A norm of something linear in depth is convex: its chord bounds it, and is largest at an end.
    const auto at = [&](Real depth) {
        const Real t =
            range > 0 ? std::clamp((depth - pyramid.nearest()) / range, Real(0), Real(1)) : Real(0);
        return margin.near + t * (margin.far - margin.near);
    };
    const Real room = Real(1.1 * kFoldShare) * reach.stretch * std::max(at(reach.low), at(reach.high));
    Box<Real> box = pyramid.box(node, reach.low - room, reach.high + room, lean);
    box.low_a -= room;
    box.high_a += room;
    box.low_b -= room;
    box.high_b += room;
    return box;
}

/// Nodes that can matter to any of the points: not much larger than the region of all of them.
template <class Real>
std::vector<typename PointQuery<Real>::FoundNode> PointQuery<Real>::find_nodes(
    std::span<const Receiver<Real>> locals, bool& folds_found) const {
    const BeamPyramid<Real>& pyramid = sheet_.pyramid();
    std::vector<FoundNode> nodes;
    folds_found = true;
    if (pyramid.empty() || locals.empty()) return nodes;
    Box<Real> bounds = point_box(locals.front());
    Reach all = reach(locals.front());
    for (const Receiver<Real>& r : locals) {
        const Box<Real> own = point_box(r);
        const Reach one = reach(r);
        bounds = {std::min(bounds.low_a, own.low_a), std::max(bounds.high_a, own.high_a),
                  std::min(bounds.low_b, own.low_b), std::max(bounds.high_b, own.high_b)};
        all = {std::min(all.low, one.low), std::max(all.high, one.high), std::max(all.lean, one.lean),
               all.plane && on_one_plane(*all.plane, r) ? all.plane : nullptr,
               std::max(all.stretch, one.stretch)};
    }
    const Real small_a = (bounds.high_a - bounds.low_a) / 4, small_b = (bounds.high_b - bounds.low_b) / 4;
    const auto search = [&](bool folds) {
        nodes.clear();
        std::vector<NodeId> open{pyramid.root()};
        while (!open.empty() && (!folds || nodes.size() <= kMostFoldNodes)) {
            const NodeId node = open.back();
            open.pop_back();
            if (pyramid.dark(node)) continue;
            const Real leans = lean(node, all);
            const Box<Real> covered = covered_box(node, all, leans);
            const Box<Real> reached = folds ? reached_box(node, all, leans) : covered;
            if (!overlap(reached, bounds)) continue;
            const Real size_a = reached.high_a - reached.low_a, size_b = reached.high_b - reached.low_b;
            if (node.level == 0 || (size_a < small_a && size_b < small_b))
                nodes.push_back({node, covered, reached});
            else
                pyramid.visit_children(node, [&](NodeId child) { open.push_back(child); });
        }
        return open.empty();
    };
    folds_found = search(true);
    if (!folds_found) search(false);
    return nodes;
}

/// Which way round a beam lands that has not turned over: the tangent plane's coordinates against its normal,
/// and whether light comes down through the water's facets, which are counter-clockwise seen from the air.
template <class Real>
int PointQuery<Real>::upright(const Receiver<Real>& local) const {
    const bool turned = glm::dot(glm::cross(local.u, local.v), local.normal) < 0;
    return turned != sheet_.sheet().in_water() ? 1 : -1;
}

template <class Real>
template <class Visit>
void PointQuery<Real>::visit_hits(const Receiver<Real>& local, std::span<const FoundNode> nodes,
                                  Wanted wanted, bool& fold, Visit&& visit) const {
    const BeamPyramid<Real>& pyramid = sheet_.pyramid();
    const LandingFrame<Real> frame(local);
    const Reach at = reach(local);
    const Box<Real> own = point_box(local);
    const int upright = this->upright(local);
    const bool every_fold = wanted == Wanted::every_fold;
    std::size_t looked_for_folds = 0;
    // A point that has its flag needs no other.
    const auto look_for_folds = [&] { return every_fold || !fold; };
    const auto look_at = [&](NodeId node) {
        if (look_for_folds() && !every_fold && ++looked_for_folds > kMostFoldClusters) fold = true;
        ClusterRays<Real> rays;
        load(sheet_.sheet(), sheet_.triangles(), pyramid.beams(node), rays);
        for (int c = 0; c < kChunks<Real>; ++c) {
            LandedChunk<Real> landed;
            land(rays, c, frame, landed);
            const auto& x = landed.beams.x;
            const auto& y = landed.beams.y;
            const unsigned around =
                bits((lesser(lesser(x[0], x[1]), x[2]) <= 0) & (greater(greater(x[0], x[1]), x[2]) >= 0) &
                     (lesser(lesser(y[0], y[1]), y[2]) <= 0) & (greater(greater(y[0], y[1]), y[2]) >= 0));
            unsigned lanes = bits(landed.lands) & (look_for_folds() ? ~0u : around);
            for (; lanes != 0; lanes &= lanes - 1) {
                const int lane = __builtin_ctz(lanes);
                const std::uint32_t beam =
                    rays.beam[static_cast<std::size_t>(c) * kLanes<Real> + static_cast<std::size_t>(lane)];
                const bool own_fold =
                    look_for_folds() && may_fold_[beam] != 0 && near_fold(local, frame, beam);
                fold |= own_fold;
                if ((around >> lane & 1) == 0) continue;
                Landed corner[3];
                for (int k = 0; k < 3; ++k)
                    corner[k] = {static_cast<float>(x[k][lane]), static_cast<float>(y[k][lane])};
                const int held = holds(corner[0], corner[1], corner[2]);
                if (held == 0) continue;
                PointHit<Real> hit{beam, held * upright, {0, 0, 0}, own_fold};
                const Real past = weigh(corner, landed, lane, hit.weights);
                if (past >= 0) visit(hit);
            }
        }
    };
    const auto done = [&] { return wanted == Wanted::fold && fold; };
    std::vector<NodeId> open;
    // Where so many clusters reach the point that it has its flag in any case, there is no need to land them.
    if (wanted == Wanted::fold && !fold && nodes.size() > kMostFoldClusters) {
        std::size_t reaching = 0;
        for (auto found = nodes.rbegin(); found != nodes.rend() && !fold; ++found) {
            if (!overlap(found->covered, own) && !overlap(found->reached, own)) continue;
            open.push_back(found->node);
            while (!open.empty()) {
                const NodeId node = open.back();
                open.pop_back();
                if (pyramid.dark(node)) continue;
                const Real leans = lean(node, at);
                if (!overlap(covered_box(node, at, leans), own) &&
                    !overlap(reached_box(node, at, leans), own))
                    continue;
                if (node.level > 0)
                    pyramid.visit_children(node, [&](NodeId child) { open.push_back(child); });
                else
                    ++reaching;
            }
            fold = reaching > kMostFoldClusters;
        }
    }
    // First the clusters that may hold the point, then those that reach it by their folds only.
    for (const bool by_folds : {false, true}) {
        if (done() || (by_folds && !look_for_folds())) return;
        for (auto found = nodes.rbegin(); found != nodes.rend(); ++found)
            if (overlap(by_folds ? found->reached : found->covered, own)) open.push_back(found->node);
        while (!open.empty() && !done() && (!by_folds || look_for_folds())) {
            const NodeId node = open.back();
            open.pop_back();
            if (pyramid.dark(node)) continue;
            const Real leans = lean(node, at);
            const bool covers = overlap(covered_box(node, at, leans), own);
            if (!covers && !(by_folds && overlap(reached_box(node, at, leans), own))) continue;
            if (node.level > 0)
                pyramid.visit_children(node, [&](NodeId child) { open.push_back(child); });
            else if (covers != by_folds)
                look_at(node);
        }
    }
}

template <class Real>
bool PointQuery<Real>::near_fold(const Receiver<Real>& local, const LandingFrame<Real>& frame,
                                 std::uint32_t beam) const {
    const auto& sheet = sheet_.sheet();
    // The landing point of a vertex as in `land`, which gives the same bits for all beams.
    struct Place {
        Landed at;
        bool lands;
    };
    const auto place = [&](std::uint32_t vertex) {
        const auto& ray = sheet.rays[vertex];
        const Real a = ray.a + frame.position.z * ray.slope_a - frame.position.x;
        const Real b = ray.b + frame.position.z * ray.slope_b - frame.position.y;
        const Real facing = frame.normal.x * ray.slope_a + frame.normal.y * ray.slope_b + frame.normal.z;
        const Real further = (frame.normal.x * a + frame.normal.y * b) / -facing;
        const auto along = [&](const Vec3<Real>& axis) {
            return static_cast<float>(axis.x * a + axis.y * b +
                                      further * (axis.x * ray.slope_a + axis.y * ray.slope_b + axis.z));
        };
        return Place{{along(frame.along_x), along(frame.along_y)}, facing < Real(-1e-4)};
    };
    const glm::uvec3& corners = sheet_.triangles()[beam];
    const Place own[3] = {place(corners[0]), place(corners[1]), place(corners[2])};
    const int own_sign = orientation(own[0].at, own[1].at, own[2].at);
    for (int edge = 0; edge < 3; ++edge) {
        const Neighbor neighbor = neighbors_.across(beam, edge);
        if (neighbor.triangle == kNoBeam || !(sheet.flux[neighbor.triangle] > 0)) continue;
        const Place &a = own[edge], &b = own[(edge + 1) % 3], &c = own[(edge + 2) % 3],
                    d = place(neighbor.vertex);
        if (!d.lands) continue;
        // Seen over the edge the neighbour's corners run the other way.
        if (orientation(b.at, a.at, d.at) == own_sign) continue;
        const auto metres = [&](const Place& p) {
            return static_cast<double>(p.at.x) * glm::dvec3(local.u) +
                   static_cast<double>(p.at.y) * glm::dvec3(local.v);
        };
        const glm::dvec3 from = metres(a), to = metres(b), way = to - from;
        const double length = glm::length(way);
        if (!(length > 0)) continue;
        // Across the edge alone: along it a fold may slide without passing the point.
        const glm::dvec3 across = glm::cross(glm::dvec3(local.normal), way) / length;
        double bend = std::abs(glm::dot(across, metres(c) + metres(d) - from - to));
        for (int step = 1; step < 3; ++step) {
            const int other = (edge + step) % 3;
            const Neighbor beside = neighbors_.across(beam, other);
            if (beside.triangle == kNoBeam || !(sheet.flux[beside.triangle] > 0)) continue;
            const Place e = place(beside.vertex);
            if (!e.lands) continue;
            bend = std::max(
                bend, std::abs(glm::dot(across, metres(own[(other + 2) % 3]) + metres(e) -
                                                    metres(own[other]) - metres(own[(other + 1) % 3]))));
        }
        const double t = std::clamp(-glm::dot(from, way) / (length * length), 0.0, 1.0);
        if (glm::length(from + t * way) < kFoldShare * bend) return true;
    }
    return false;
}

/// Paths to points that share a plane: beams are landed on it once, in the first point's frame, and their
/// corners moved to the other points: all beams of a vertex by the same bits.
template <class Real>
void PointQuery<Real>::count_on_plane(std::span<const Receiver<Real>> locals,
                                      std::span<const FoundNode> nodes,
                                      std::span<PointSummary> summaries) const {
    const BeamPyramid<Real>& pyramid = sheet_.pyramid();
    const LandingFrame<Real> frame(locals.front());
    const int upright = this->upright(locals.front());
    std::vector<glm::vec<2, Real>> places;
    for (const Receiver<Real>& local : locals) {
        const Vec3<Real> offset = local.position - frame.position;
        places.emplace_back(glm::dot(frame.along_x, offset), glm::dot(frame.along_y, offset));
    }
    Box<Real> bounds = point_box(locals.front());
    Reach at = reach(locals.front());
    for (const Receiver<Real>& local : locals) {
        const Box<Real> own = point_box(local);
        bounds = {std::min(bounds.low_a, own.low_a), std::max(bounds.high_a, own.high_a),
                  std::min(bounds.low_b, own.low_b), std::max(bounds.high_b, own.high_b)};
        at.low = std::min(at.low, local.position.z);
        at.high = std::max(at.high, local.position.z);
    }
    const auto look_at = [&](NodeId node) {
        ClusterRays<Real> rays;
        load(sheet_.sheet(), sheet_.triangles(), pyramid.beams(node), rays);
        for (int c = 0; c < kChunks<Real>; ++c) {
            LandedChunk<Real> landed;
            land(rays, c, frame, landed);
            const auto &x = landed.beams.x, &y = landed.beams.y;
            const Lanes<Real> low_x = lesser(lesser(x[0], x[1]), x[2]);
            const Lanes<Real> high_x = greater(greater(x[0], x[1]), x[2]);
            const Lanes<Real> low_y = lesser(lesser(y[0], y[1]), y[2]);
            const Lanes<Real> high_y = greater(greater(y[0], y[1]), y[2]);
            const unsigned lands = bits(landed.lands);
            for (std::size_t i = 0; lands != 0 && i < places.size(); ++i) {
                const Real px = places[i].x, py = places[i].y;
                unsigned lanes =
                    lands & bits((low_x <= px) & (high_x >= px) & (low_y <= py) & (high_y >= py));
                for (; lanes != 0; lanes &= lanes - 1) {
                    const int lane = __builtin_ctz(lanes);
                    Landed corner[3];
                    for (int k = 0; k < 3; ++k)
                        corner[k] = {static_cast<float>(x[k][lane] - px),
                                     static_cast<float>(y[k][lane] - py)};
                    const int held = holds(corner[0], corner[1], corner[2]);
                    if (held == 0 || !lies_in_light(corner, landed, lane)) continue;
                    ++summaries[i].count;
                    summaries[i].sign += held * upright;
                }
            }
        }
    };
    std::vector<NodeId> open;
    for (const FoundNode& found : nodes) open.push_back(found.node);
    while (!open.empty()) {
        const NodeId node = open.back();
        open.pop_back();
        if (pyramid.dark(node) || !overlap(covered_box(node, at, lean(node, at)), bounds)) continue;
        if (node.level == 0)
            look_at(node);
        else
            pyramid.visit_children(node, [&](NodeId child) { open.push_back(child); });
    }
}

template <class Real>
void PointQuery<Real>::summarize(std::span<const Receiver<Real>> points,
                                 std::span<PointSummary> summaries) const {
    std::vector<Receiver<Real>> locals;
    locals.reserve(points.size());
    for (const Receiver<Real>& point : points) locals.push_back(sheet_.rotated(point));
    bool folds_found = true;
    const std::vector<FoundNode> nodes = find_nodes(locals, folds_found);
    if (nodes.empty()) return;
    const bool together = std::all_of(locals.begin(), locals.end(), [&](const Receiver<Real>& local) {
        return on_one_plane(locals.front(), local);
    });
    if (together) count_on_plane(locals, nodes, summaries);
    for (std::size_t i = 0; i < locals.size(); ++i) {
        PointSummary& summary = summaries[i];
        summary.fold |= !folds_found;
        visit_hits(locals[i], nodes, together ? Wanted::fold : Wanted::hits, summary.fold,
                   [&](const PointHit<Real>& hit) {
                       summary.count += together ? 0 : 1;
                       summary.sign += together ? 0 : hit.sign;
                   });
    }
}

template <class Real>
std::vector<PointHit<Real>> PointQuery<Real>::hits(const Receiver<Real>& point, bool& fold) const {
    std::vector<PointHit<Real>> found;
    const Receiver<Real> local = sheet_.rotated(point);
    bool folds_found = true;
    const std::vector<FoundNode> nodes = find_nodes({&local, 1}, folds_found);
    fold |= !folds_found;
    visit_hits(local, nodes, Wanted::every_fold, fold,
               [&](const PointHit<Real>& hit) { found.push_back(hit); });
    return found;
}

template class PointQuery<float>;
template class PointQuery<double>;

}  // namespace dapple::methods::sliced_beams
