#include "methods/sliced_beams/scatter_query.h"

#include <algorithm>
#include <limits>

#include "methods/sliced_beams/positive_parts.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Parts of an interval that are asked one by one whether an object hides them from the light: by rays, and
/// where the beam's area changes by more than kEvenShadows.
constexpr int kShadowParts = 4;
constexpr double kEvenShadows = 0.5;
constexpr std::size_t kPairsAtOnce = 4096;

}  // namespace

template <class Real>
void ScatterQuery<Real>::run() {
    const BeamPyramid<Real>& pyramid = sheet_.coverage_.pyramid();
    // Each cluster waits until the next one is found, while it comes from memory.
    const BeamCluster<Real>* waiting = nullptr;
    L waits_from{}, waits_to{};
    const auto take_waiting = [&] {
        if (waiting == nullptr) return;
        const Mask<Real> met = waits_from <= waits_to;
        counts_.clusters += static_cast<std::size_t>(__builtin_popcount(bits(met)));
        take_part(waits_from, waits_to, met);
        add_cluster(*waiting, met);
    };
    sheet_.bounds_.visit(segments_, direction_.shift,
                         [&](typename BeamPyramid<Real>::NodeId node, const L& from, const L& to) {
                             const BeamCluster<Real>& found = sheet_.clusters_[pyramid.index(node)];
                             found.prefetch();
                             take_waiting();
                             waiting = &found;
                             waits_from = from;
                             waits_to = to;
                         });
    take_waiting();
    settle_moments();
    settle_pairs();
}

template <class Real>
void ScatterQuery<Real>::take_part(const L& from, const L& to, const Mask<Real>& met) {
    middle_ = met ? Real(0.5) * (from + to) : L{};
    half_ = met ? Real(0.5) * (to - from) : L{};
    const SegmentLanes<Real>& s = segments_;
    part_ = {multiply_add(middle_, s.to_a, s.a),
             multiply_add(middle_, s.to_b, s.b),
             multiply_add(middle_, s.to_depth, s.depth),
             half_ * s.to_a,
             half_ * s.to_b,
             half_ * s.to_depth};
}

template <class Real>
void ScatterQuery<Real>::add_cluster(const BeamCluster<Real>& cluster, const Mask<Real>& met) {
    const light::BeamSheet<Real>& sheet = sheet_.coverage_.sheet();
    counts_.beams += static_cast<std::size_t>(kLanes<Real> * cluster.beams);
    cluster.corners(direction_.shift, corners_);
    cluster_.find(cluster, corners_, part_, met);
    const bool free = lies_free(cluster, met);
    by_moments_ = begin_moments(cluster, met);
    const typename BeamCluster<Real>::Beam* known = nullptr;
    cluster_.visit_pieces([&](int i, const L& enter, const L& leave, const Mask<Real>& mask) {
        const auto& beam = cluster.beam[i];
        if (&beam != known) {
            known = &beam;
            beam_ = beam.triangle;
            shade_ = beam.shade;
            flux_ = 2 * sheet.flux[beam_];
            if (!sheet.tint.empty()) color_ = Vec3<Real>(sheet.color) * sheet.tint[beam_];
            for (int k = 0; k < 3; ++k) {
                corner_[k] = corners_[beam.corner[k]];
                edge_[k] = &cluster_.edge(i, k);
            }
            area_ = cluster_.area(i);
        }
        if (free || lies_free(enter, leave, mask))
            take_piece(enter, leave, mask);
        else
            cut_piece(enter, leave, mask);
    });
}

template <class Real>
bool ScatterQuery<Real>::lies_free(const BeamCluster<Real>& cluster, const Mask<Real>& met) const {
    const L reach = magnitude(part_.half_depth);
    return !any(met &
                ((part_.depth - reach < cluster.last_start) | (part_.depth + reach > cluster.first_stop)));
}

template <class Real>
bool ScatterQuery<Real>::lies_free(const L& enter, const L& leave, const Mask<Real>& mask) const {
    const L first = multiply_add(enter, part_.half_depth, part_.depth);
    const L last = multiply_add(leave, part_.half_depth, part_.depth);
    const Real start = std::max({corner_[0].start, corner_[1].start, corner_[2].start});
    if (any(mask & (lesser(first, last) < start))) return false;
    if (!(shade_ & Ways::kCut)) return true;
    const glm::uvec3& t = sheet_.coverage_.triangles()[beam_];
    const Real stop = std::min({sheet_.ways_.stop(t.x), sheet_.ways_.stop(t.y), sheet_.ways_.stop(t.z)});
    return !any(mask & (greater(first, last) > stop));
}

template <class Real>
void ScatterQuery<Real>::cut_piece(const L& enter, const L& leave, const Mask<Real>& mask) {
    const glm::uvec3& triangle = sheet_.coverage_.triangles()[beam_];
    const bool stops = (shade_ & Ways::kCut) != 0;
    constexpr int kMost = 4;
    L from[kMost], to[kMost];
    Mask<Real> kept[kMost] = {};
    for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
        const double depth = at(part_.depth), grows = at(part_.half_depth);
        const double middle = 0.5 * (at(enter) + at(leave));
        double edge[3][3];  // positive within
        for (int k = 0; k < 3; ++k) {
            const double c0 = at(edge_[k]->c0), c1 = at(edge_[k]->c1), c2 = at(edge_[k]->c2);
            const double sign = c0 + middle * (c1 + middle * c2) < 0 ? -1 : 1;
            edge[k][0] = sign * c0;
            edge[k][1] = sign * c1;
            edge[k][2] = sign * c2;
        }
        const auto beyond = [&](auto&& place, double sign, double(&c)[4]) {
            std::fill(c, c + 4, 0.0);
            for (int k = 0; k < 3; ++k) {
                const double e0 = sign * (depth - static_cast<double>(place(k))), e1 = sign * grows;
                for (int i = 0; i < 3; ++i) {
                    c[i] += edge[k][i] * e0;
                    c[i + 1] += edge[k][i] * e1;
                }
            }
        };
        double after_start[4], before_stop[4];
        beyond([&](int k) { return corner_[k].start; }, 1, after_start);
        Part below[2], parts[2];
        int count = 0;
        const int below_count = positive_parts(after_start, at(enter), at(leave), below);
        for (int i = 0; i < below_count; ++i) {
            int part_count = 1;
            parts[0] = below[i];
            if (stops) {
                beyond([&](int k) { return sheet_.ways_.stop(triangle[k]); }, -1, before_stop);
                part_count = positive_parts(before_stop, below[i].from, below[i].to, parts);
            }
            for (int j = 0; j < part_count; ++j, ++count) {
                from[count][lane] = static_cast<Real>(parts[j].from);
                to[count][lane] = static_cast<Real>(parts[j].to);
                kept[count][lane] = -1;
            }
        }
        ++counts_.cut;
    }
    for (int i = 0; i < kMost; ++i) {
        const Mask<Real> present = kept[i];
        if (!any(present)) break;
        take_piece(present ? from[i] : enter, present ? to[i] : leave, present);
    }
}

template <class Real>
void ScatterQuery<Real>::take_piece(const L& enter, const L& leave, const Mask<Real>& mask) {
    counts_.intervals += static_cast<std::size_t>(__builtin_popcount(bits(mask)));
    if (shade_ & (Ways::kMixedAfter | Ways::kMixedBefore))
        add_shadowed(enter, leave, mask);
    else
        add_lit(enter, leave, mask);
}

template <class Real>
void ScatterQuery<Real>::add_shadowed(const L& enter, const L& leave, const Mask<Real>& mask) {
    const typename Ways::Blockers& blockers = sheet_.ways_.blockers(beam_);
    if (((blockers.after | blockers.before) & sheet_.shapes_.known()) == 0)
        return add_traced(enter, leave, mask);
    const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    const L q1 = half * multiply_add(Real(2) * area_.c2, middle, area_.c1), q2 = half * half * area_.c2;
    // Where the beam narrows, what is linear in depth is not along the segment.
    const Mask<Real> uneven =
        mask & ~(magnitude(q1) + Real(3) * magnitude(q2) <= Real(kEvenShadows) * magnitude(area_(middle)));
    const int parts = any(uneven) ? kShadowParts : 1;
    for (int i = 0; i < parts; ++i) {
        const auto at = [&](int k) {
            return enter + (leave - enter) * (static_cast<Real>(k) / static_cast<Real>(parts));
        };
        add_shadowed_part(at(i), at(i + 1), mask);
    }
}

template <class Real>
void ScatterQuery<Real>::add_shadowed_part(const L& enter, const L& leave, const Mask<Real>& mask) {
    const typename Ways::Blockers& blockers = sheet_.ways_.blockers(beam_);
    const ObjectSet known = sheet_.shapes_.known();
    const bool traced = ((blockers.after | blockers.before) & ~known) != 0;
    const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    WayLanes<Real> ways;  // from points to the water
    const L places[3] = {enter, middle, leave};
    for (int i = 0; i < 3; ++i) {
        const BeamRay r = ray(places[i]);
        PointLanes<Real>& point = ways.from[i];
        point = {multiply_add(places[i], part_.half_a, part_.a),
                 multiply_add(places[i], part_.half_b, part_.b),
                 multiply_add(places[i], part_.half_depth, part_.depth)};
        const L below = point.depth - r.start;
        ways.to[i] = {point.a - below * r.slope_a, point.b - below * r.slope_b, r.start};
    }
    counts_.shadow_tests += 3 * static_cast<std::size_t>(__builtin_popcount(bits(mask)));
    LitParts<Real> lit(mask);
    sheet_.shapes_.darken(blockers.after & known, ways, lit);
    if ((blockers.before & known) != 0 && lit.any_lit()) {
        const bool sun = direction_.to_sun != glm::vec3(0);
        const glm::vec<3, Real> light(
            (sun ? static_cast<double>(sheet_.shapes_.beyond()) * glm::dvec3(direction_.to_sun)
                 : sheet_.coverage_.lamp()) *
            sheet_.coverage_.sheet().world_from_mesh);
        for (int i = 0; i < 3; ++i) {
            const PointLanes<Real> water = ways.to[i];
            ways.from[i] = water;
            ways.to[i] = {splat(light.x), splat(light.y), splat(light.z)};
            if (sun) ways.to[i] = {water.a + light.x, water.b + light.y, water.depth + light.z};
        }
        sheet_.shapes_.darken(blockers.before & known, ways, lit);
    }
    lit.visit([&](const L& from, const L& to, const Mask<Real>& lanes) {
        const L first = multiply_add(half, from, middle), last = multiply_add(half, to, middle);
        if (traced)
            add_traced(first, last, lanes);
        else
            add_lit(first, last, lanes);
    });
}

template <class Real>
void ScatterQuery<Real>::add_traced(const L& enter, const L& leave, const Mask<Real>& mask) {
    const glm::dmat3& world_from_sheet = sheet_.coverage_.sheet().world_from_mesh;
    for (int i = 0; i < kShadowParts; ++i) {
        const auto at = [&](int k) {
            return enter + (leave - enter) * (static_cast<Real>(k) / kShadowParts);
        };
        L light[3] = {};
        target_ = &light;
        const L from = at(i), to = at(i + 1), middle = Real(0.5) * (from + to);
        add_piece(from, to, mask);
        target_ = &radiance_;
        const BeamRay r = ray(middle);
        const L depth = multiply_add(middle, part_.half_depth, part_.depth);
        for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1) {
            const int lane = __builtin_ctz(lanes);
            const glm::dvec3 point(part_.a[lane] + middle[lane] * part_.half_a[lane],
                                   part_.b[lane] + middle[lane] * part_.half_b[lane], depth[lane]);
            const double below = static_cast<double>(depth[lane] - r.start[lane]);
            const glm::dvec3 water = point - below * glm::dvec3(r.slope_a[lane], r.slope_b[lane], 1);
            pairs_.push_back({lane, Vec3<Real>(light[0][lane], light[1][lane], light[2][lane]),
                              glm::vec3(world_from_sheet * point), glm::vec3(world_from_sheet * water),
                              (shade_ & Ways::kMixedAfter) && depth[lane] > sheet_.ways_.free_depth(beam_),
                              (shade_ & Ways::kMixedBefore) != 0});
        }
    }
    if (pairs_.size() >= kPairsAtOnce) settle_pairs();
}

template <class Real>
void ScatterQuery<Real>::settle_pairs() {
    if (pairs_.empty()) return;
    trace(true);
    trace(false);
    for (const Pair& pair : pairs_)
        for (int c = 0; c < 3; ++c) radiance_[c][pair.lane] += pair.light[c];
    pairs_.clear();
}

template <class Real>
void ScatterQuery<Real>::trace(bool after) {
    const glm::vec3 lamp(sheet_.coverage_.lamp());
    const bool sun = direction_.to_sun != glm::vec3(0);
    std::vector<rays::Ray> rays;
    for (const Pair& pair : pairs_) {
        if (after && pair.after)
            rays.push_back({pair.point, 0, pair.water - pair.point, 1});
        else if (!after && pair.before)
            rays.push_back({pair.water, 0, sun ? direction_.to_sun : lamp - pair.water,
                            sun ? std::numeric_limits<float>::infinity() : 1.0f});
    }
    if (rays.empty()) return;
    std::vector<std::uint8_t> blocked(rays.size(), 0);
    sheet_.coverage_.rays().occluded_by_objects(rays, blocked);
    counts_.shadow_rays += rays.size();
    std::size_t ray = 0;
    std::erase_if(pairs_,
                  [&](const Pair& pair) { return (after ? pair.after : pair.before) && blocked[ray++]; });
}

template void ScatterQuery<float>::run();
template void ScatterQuery<double>::run();

}  // namespace dapple::methods::sliced_beams
