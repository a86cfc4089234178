#include "methods/sliced_beams/scatter_sheet.h"

#include <algorithm>
#include <cmath>

#include "methods/sliced_beams/exponential.h"
#include "methods/sliced_beams/positive_parts.h"
#include "methods/sliced_beams/segment_quadrature.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Optical depth of an interval that three nodes are enough for: relative error of the integral of e^-x, 2e-7
/// in float, 4e-10 in double.
template <class Real>
constexpr Real kThinEnough = sizeof(Real) == 4 ? Real(1) : Real(0.35);
/// Where two nodes are as good: change of the area on the interval, relative, and optical depth.
constexpr double kTwoNodesEven = 0.1, kTwoNodesThin = 0.25;
/// Light beyond so many optical depths, e^-60 of it, is left out.
constexpr double kOpaque = 60;
/// Parts of an interval that are asked one by one whether an object hides them from the light.
constexpr int kShadowParts = 4;
constexpr std::size_t kPairsAtOnce = 4096;

}  // namespace

void ScatterCounts::add(const ScatterCounts& other) {
    clusters += other.clusters;
    beams += other.beams;
    intervals += other.intervals;
    peaks += other.peaks;
    cut += other.cut;
    shadow_rays += other.shadow_rays;
    foci += other.foci;
    dropped += other.dropped;
}

void ScatterCounts::report(FrameStats& stats) const {
    stats.count("segments times clusters", static_cast<double>(clusters));
    stats.count("segments times beams", static_cast<double>(beams));
    stats.count("intervals in beams", static_cast<double>(intervals));
    stats.count("intervals that peak", static_cast<double>(peaks));
    stats.count("intervals cut", static_cast<double>(cut));
    stats.count("volume shadow rays", static_cast<double>(shadow_rays));
    if (foci > 0) stats.count("intervals through foci", static_cast<double>(foci));
    if (dropped > 0) stats.count("intervals not finite", static_cast<double>(dropped));
}

/// One query of a ScatterSheet.
template <class Real>
class ScatterQuery {
public:
    using L = Lanes<Real>;
    using Ways = BeamWays<Real>;

    ScatterQuery(const ScatterSheet<Real>& sheet, const SegmentLanes<Real>& segments,
                 const LightDirection<Real>& direction, const EvenMedium<Real>& medium,
                 const UnevenGroup<Real>* uneven, L (&radiance)[3], ScatterCounts& counts)
        : sheet_(sheet),
          segments_(segments),
          direction_(direction),
          medium_(medium),
          uneven_(uneven),
          radiance_(radiance),
          target_(&radiance),
          counts_(counts),
          color_(sheet.coverage_.sheet().color),
          scattered_(uneven ? uneven->phases.size() : 0) {}

    void run() {
        const BeamPyramid<Real>& pyramid = sheet_.coverage_.pyramid();
        sheet_.bounds_.visit(segments_, direction_.shift,
                             [&](typename BeamPyramid<Real>::NodeId node, const L& from, const L& to) {
                                 const Mask<Real> met = from <= to;
                                 counts_.clusters += static_cast<std::size_t>(__builtin_popcount(bits(met)));
                                 take_part(from, to, met);
                                 for (const std::uint32_t beam : pyramid.beams(node)) add_beam(beam, met);
                             });
        settle_pairs();
    }

private:
    void take_part(const L& from, const L& to, const Mask<Real>& met) {
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

    void add_beam(std::uint32_t beam, const Mask<Real>& met) {
        const light::BeamSheet<Real>& sheet = sheet_.coverage_.sheet();
        if (beam == kNoBeam || !(sheet.flux[beam] > 0)) return;
        const std::uint8_t shade = sheet_.ways_.shade(beam);
        if (shade & Ways::kDark) return;
        counts_.beams += static_cast<std::size_t>(kLanes<Real>);
        sheet_.corners(beam, direction_.shift, corner_);
        slices_ = slices(corner_, part_);
        beam_ = beam;
        flux_ = 2 * sheet.flux[beam];
        visit_pieces(slices_, met, [&](const L& enter, const L& leave, const Mask<Real>& mask) {
            if (lies_free(beam, enter, leave, mask))
                take_piece(beam, enter, leave, mask);
            else
                cut_piece(beam, enter, leave, mask);
        });
    }

    /// Whether all of the piece is below the surface, and before an object that stops the beam.
    bool lies_free(std::uint32_t beam, const L& enter, const L& leave, const Mask<Real>& mask) const {
        const L first = multiply_add(enter, part_.half_depth, part_.depth);
        const L last = multiply_add(leave, part_.half_depth, part_.depth);
        const Real start = std::max({corner_[0].start, corner_[1].start, corner_[2].start});
        if (any(mask & (lesser(first, last) < start))) return false;
        if (!(sheet_.ways_.shade(beam) & Ways::kCut)) return true;
        const glm::uvec3& t = sheet_.coverage_.triangles()[beam];
        const Real stop = std::min({sheet_.ways_.stop(t.x), sheet_.ways_.stop(t.y), sheet_.ways_.stop(t.z)});
        return !any(mask & (greater(first, last) > stop));
    }

    /// Takes what lies beyond the surface and before the stop, both linear over the beam's slices: a point
    /// is, where a cubic, the edges' areas times the corners' distances, has the sign of the area.
    void cut_piece(std::uint32_t beam, const L& enter, const L& leave, const Mask<Real>& mask) {
        const glm::uvec3& triangle = sheet_.coverage_.triangles()[beam];
        const bool stops = (sheet_.ways_.shade(beam) & Ways::kCut) != 0;
        constexpr int kMost = 4;
        L from[kMost], to[kMost];
        Mask<Real> kept[kMost] = {};
        for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1) {
            const int lane = __builtin_ctz(lanes);
            const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
            const double depth = at(part_.depth), grows = at(part_.half_depth);
            const double middle = 0.5 * (at(enter) + at(leave));
            const double turned =
                at(slices_.edge[0].c0) + middle * (at(slices_.edge[0].c1) + middle * at(slices_.edge[0].c2)) <
                        0
                    ? -1
                    : 1;
            const auto beyond = [&](auto&& place, double sign, double(&c)[4]) {
                std::fill(c, c + 4, 0.0);
                for (int k = 0; k < 3; ++k) {
                    const double e0 = sign * (depth - static_cast<double>(place(k))), e1 = sign * grows;
                    const double w[3] = {turned * at(slices_.edge[k].c0), turned * at(slices_.edge[k].c1),
                                         turned * at(slices_.edge[k].c2)};
                    for (int i = 0; i < 3; ++i) {
                        c[i] += w[i] * e0;
                        c[i + 1] += w[i] * e1;
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
            take_piece(beam, present ? from[i] : enter, present ? to[i] : leave, present);
        }
    }

    void take_piece(std::uint32_t beam, const L& enter, const L& leave, const Mask<Real>& mask) {
        counts_.intervals += static_cast<std::size_t>(__builtin_popcount(bits(mask)));
        if (sheet_.ways_.shade(beam) & (Ways::kMixedAfter | Ways::kMixedBefore))
            add_shadowed(beam, enter, leave, mask);
        else
            add_piece(enter, leave, mask);
    }

    /// Where an object may stand among a beam's rays.
    void add_shadowed(std::uint32_t beam, const L& enter, const L& leave, const Mask<Real>& mask) {
        const std::uint8_t shade = sheet_.ways_.shade(beam);
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
            const Node n = node(middle);
            const L depth = multiply_add(middle, part_.half_depth, part_.depth);
            for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1) {
                const int lane = __builtin_ctz(lanes);
                const glm::dvec3 point(part_.a[lane] + middle[lane] * part_.half_a[lane],
                                       part_.b[lane] + middle[lane] * part_.half_b[lane], depth[lane]);
                const double below = static_cast<double>(depth[lane] - n.start[lane]);
                const glm::dvec3 water = point - below * glm::dvec3(n.slope_a[lane], n.slope_b[lane], 1);
                pairs_.push_back({lane, Vec3<Real>(light[0][lane], light[1][lane], light[2][lane]),
                                  glm::vec3(world_from_sheet * point), glm::vec3(world_from_sheet * water),
                                  (shade & Ways::kMixedAfter) && depth[lane] > sheet_.ways_.free_depth(beam),
                                  (shade & Ways::kMixedBefore) != 0});
            }
        }
        if (pairs_.size() >= kPairsAtOnce) settle_pairs();
    }

    void settle_pairs() {
        if (pairs_.empty()) return;
        trace(true);
        trace(false);
        for (const Pair& pair : pairs_)
            for (int c = 0; c < 3; ++c) radiance_[c][pair.lane] += pair.light[c];
        pairs_.clear();
    }

    /// Drops the pairs that an object hides after the water, or before it.
    void trace(bool after) {
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

    /// The ray through a point of the beam.
    struct Node {
        L path;     ///< m from the water to the point, and back to the segment's near end
        L stretch;  ///< m of way a m of depth
        L sine;     ///< of half the angle between the ways before and after
        L slope_a, slope_b, start;
    };
    Node node(const L& t) const {
        const L w0 = slices_.edge[0](t), w1 = slices_.edge[1](t), w2 = slices_.edge[2](t);
        const L whole = w0 + w1 + w2;
        const auto thin = whole == 0;
        const L scale = splat(Real(1)) / (thin ? splat(Real(1)) : whole);
        const L l1 = thin ? splat(Real(1) / 3) : w1 * scale, l2 = thin ? splat(Real(1) / 3) : w2 * scale;
        const auto mix = [&](Real v0, Real v1, Real v2) {
            return multiply_add(l1, splat(v1 - v0), multiply_add(l2, splat(v2 - v0), splat(v0)));
        };
        const auto& [c0, c1, c2] = corner_;
        Node n;
        n.slope_a = mix(c0.slope_a, c1.slope_a, c2.slope_a);
        n.slope_b = mix(c0.slope_b, c1.slope_b, c2.slope_b);
        n.start = mix(c0.start, c1.start, c2.start);
        const L depth = multiply_add(t, part_.half_depth, part_.depth);
        n.stretch = square_root<Real>(
            multiply_add(n.slope_a, n.slope_a, multiply_add(n.slope_b, n.slope_b, splat(Real(1)))));
        n.path = multiply_add(depth - n.start, n.stretch, multiply_add(t, half_, middle_));
        if (!medium_.phase->even()) {
            // |before - after| / 2: half the angle between unit vectors loses no digits so.
            const L unit = splat(Real(1)) / n.stretch;
            const L a = multiply_add(n.slope_a, unit, segments_.to_a);
            const L b = multiply_add(n.slope_b, unit, segments_.to_b);
            const L d = unit + segments_.to_depth;
            n.sine = Real(0.5) * square_root<Real>(a * a + b * b + d * d);
        }
        return n;
    }

    void add_piece(const L& enter, const L& leave, Mask<Real> mask) {
        if (uneven_) {
            const bool dimmed = sheet_.coverage_.columns().dims(sheet_.coverage_.triangles()[beam_]);
            const Mask<Real> uneven = dimmed ? mask : mask & uneven_->uneven;
            for (unsigned lanes = bits(uneven); lanes != 0; lanes &= lanes - 1)
                add_uneven(enter, leave, __builtin_ctz(lanes));
            mask &= ~uneven;
            if (!any(mask)) return;
        }
        if constexpr (sizeof(Real) == 4)
            if (add_even(enter, leave, mask)) return;
        // Optical depth may be too much for one rule.
        const L from = node(enter).path, to = node(leave).path;
        const L change = mask ? magnitude(to - from) * medium_.most : L{};
        Real most = 0;
        for (int lane = 0; lane < kLanes<Real>; ++lane) most = std::max(most, change[lane]);
        if (most <= kThinEnough<Real>) return add_thin(enter, leave, mask);
        add_thick(enter, leave, from, to, mask);
    }

    /// Cut where nothing is left of the light, and into parts.
    void add_thick(L enter, L leave, const L& from, const L& to, const Mask<Real>& mask) {
        L way = magnitude(to - from);
        if (medium_.least > 0) {
            const L least = lesser(from, to);
            const L seen = splat(Real(kOpaque) / medium_.least) - greater(least, L{});
            const L share = way > 0 ? lesser(greater(seen / way, L{}), splat(Real(1))) : splat(Real(1));
            const L length = leave - enter;
            leave = from <= to ? enter + share * length : leave;
            enter = from <= to ? enter : leave - share * length;
            way *= share;
        }
        Real most = 0;
        for (int lane = 0; lane < kLanes<Real>; ++lane)
            if (mask[lane]) most = std::max(most, way[lane] * medium_.most);
        const int parts = static_cast<int>(std::min(std::ceil(most / kThinEnough<Real>), Real(1 << 20)));
        L before = enter;
        for (int i = 1; i <= parts; ++i) {
            const L after = enter + (leave - enter) * (static_cast<Real>(i) / static_cast<Real>(parts));
            add_thin(before, after, mask);
            before = after;
        }
    }

    /// Weights of the nodes for the integral over the interval's [-1, 1].
    void weigh(const L& middle, const L& half, const Mask<Real>& mask, L (&weight)[3]) {
        const L q0 = slices_.area(middle);
        const L q1 = half * multiply_add(Real(2) * slices_.area.c2, middle, slices_.area.c1);
        const L q2 = half * half * slices_.area.c2;
        const Real u = Real(kNodes[2]);
        const L even = multiply_add(q2, splat(u * u), q0);
        weight[0] = Real(kNodeWeights[0]) / magnitude(even - u * q1);
        weight[1] = Real(kNodeWeights[1]) / magnitude(q0);
        weight[2] = Real(kNodeWeights[2]) / magnitude(even + u * q1);
        const Mask<Real> peaks =
            mask & ~(magnitude(q1) + Real(3) * magnitude(q2) <= Real(kEvenEnough) * magnitude(q0));
        for (unsigned lanes = bits(peaks); lanes != 0; lanes &= lanes - 1) {
            const int lane = __builtin_ctz(lanes);
            double exact[3];
            ++counts_.peaks;
            if (product_weights(static_cast<double>(q0[lane]), static_cast<double>(q1[lane]),
                                static_cast<double>(q2[lane]), exact))
                for (int j = 0; j < 3; ++j) weight[j][lane] = static_cast<Real>(exact[j]);
            else
                ++counts_.foci;
        }
    }

    void add_thin(const L& enter, const L& leave, const Mask<Real>& mask) {
        const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
        L weight[3];
        weigh(middle, half, mask, weight);
        Node nodes[3];
        for (int j = 0; j < 3; ++j) nodes[j] = node(multiply_add(half, splat(Real(kNodes[j])), middle));
        sum_up(nodes, weight, half, mask);
    }

    /// Most intervals are so short that hardly anything changes along them: there two nodes do. False: on
    /// this one they do not.
    bool add_even(const L& enter, const L& leave, const Mask<Real>& mask) {
        const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
        const L q0 = slices_.area(middle);
        const L q1 = half * multiply_add(Real(2) * slices_.area.c2, middle, slices_.area.c1);
        const L q2 = half * half * slices_.area.c2;
        if (any(mask & ~(magnitude(q1) + Real(10) * magnitude(q2) <= Real(kTwoNodesEven) * magnitude(q0))))
            return false;
        constexpr Real u = Real(0.5773502691896258);  // Gauss & Legendre's rule, exact for degree three
        const Node nodes[2] = {node(middle - u * half), node(middle + u * half)};
        const L change = magnitude(nodes[1].path - nodes[0].path) * (medium_.most / u);
        if (any(mask & ~(change <= Real(kTwoNodesThin)))) return false;
        const L even = multiply_add(q2, splat(u * u), q0);
        L weight[2] = {Real(1) / magnitude(even - u * q1), Real(1) / magnitude(even + u * q1)};
        sum_up(nodes, weight, half, mask);
        return true;
    }

    template <int kCount>
    void sum_up(const Node (&nodes)[kCount], L (&weight)[kCount], const L& half, const Mask<Real>& mask) {
        const L scale = half * half_ * flux_;
        for (int j = 0; j < kCount; ++j)
            weight[j] *= scale * nodes[j].stretch * (*medium_.phase)(nodes[j].sine);
        for (int channel = 0; channel < 3; ++channel) {
            const Real extinction = medium_.extinction[channel];
            L sum{};
            for (int j = 0; j < kCount; ++j)
                sum += weight[j] * decay(greater(extinction * nodes[j].path, L{}));
            sum *= medium_.scattering[channel] * color_[channel];
            const auto finite = (sum - sum) == 0;
            counts_.dropped += static_cast<std::size_t>(__builtin_popcount(bits(mask & ~finite)));
            (*target_)[channel] += mask & finite ? sum : L{};
        }
    }

    /// One segment through bounded media: part by part of what it scatters, each with the exact integral of
    /// one over the area and the rest in its middle.
    void add_uneven(const L& enter, const L& leave, int lane) {
        const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
        const SegmentScatter& scatter = uneven_->scatter[lane];
        const std::span<const double> places = scatter.places();
        const double middle = at(middle_), half = at(half_);
        const double first = std::max(middle + half * at(enter), scatter.first());
        const double last = std::min(middle + half * at(leave), scatter.last());
        if (!(first < last)) return;
        auto piece =
            static_cast<std::size_t>(std::upper_bound(places.begin(), places.end(), first) - places.begin()) -
            1;
        double light[3] = {};
        for (double from = first; from < last; ++piece) {
            const double to = std::min(last, places[piece + 1]);
            if (from < to) add_part(scatter, piece, from, to, lane, light);
            from = to;
        }
        for (int c = 0; c < 3; ++c) {
            if (std::isfinite(light[c]))
                (*target_)[c][lane] += static_cast<Real>(light[c]);
            else
                counts_.dropped += 1;
        }
    }

    void add_part(const SegmentScatter& scatter, std::size_t piece, double from, double to, int lane,
                  double (&light)[3]) {
        const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
        const double middle = at(middle_), scale = 1 / at(half_);
        double t = (0.5 * (from + to) - middle) * scale;
        const double half = 0.5 * (to - from) * scale;
        const auto value = [&](const Quadratic<Real>& q) { return at(q.c0) + t * (at(q.c1) + t * at(q.c2)); };
        // Integral over [-1, 1] of one over the area.
        const double q0 = value(slices_.area);
        const double q1 = half * (at(slices_.area.c1) + 2 * t * at(slices_.area.c2));
        const double q2 = half * half * at(slices_.area.c2);
        double weight[3];
        if (std::abs(q1) + 3 * std::abs(q2) <= kEvenEnough * std::abs(q0) ||
            !product_weights(q0, q1, q2, weight)) {
            for (int j = 0; j < 3; ++j)
                weight[j] = kNodeWeights[j] / std::abs(q0 + kNodes[j] * (q1 + kNodes[j] * q2));
        }
        const double density = static_cast<double>(flux_) * 0.5 * (weight[0] + weight[1] + weight[2]);
        // What is scattered, and the centroid of it, at which the rest is taken.
        const double centre = 0.5 * (from + to);
        glm::dvec3 halves[2] = {};
        for (std::size_t i = 0; i < uneven_->phases.size(); ++i) {
            const glm::dvec3 first = scatter.scattered(i, piece, from);
            const glm::dvec3 until = scatter.scattered(i, piece, centre);
            const glm::dvec3 last = scatter.scattered(i, piece, to);
            scattered_[i] = last - first;
            halves[0] += until - first;
            halves[1] += last - until;
        }
        const double before = halves[0].x + halves[0].y + halves[0].z;
        const double after = halves[1].x + halves[1].y + halves[1].z;
        if (!(before + after > 0)) return;
        t += half * 2 / 3 * (after - before) / (before + after);
        // The ray through it.
        glm::dvec3 w(value(slices_.edge[0]), value(slices_.edge[1]), value(slices_.edge[2]));
        const double whole = w.x + w.y + w.z;
        w = whole != 0 ? w / whole : glm::dvec3(1.0 / 3);
        glm::dvec3 slope(0, 0, 1);
        double start = 0;
        for (int k = 0; k < 3; ++k) {
            slope.x += w[k] * static_cast<double>(corner_[k].slope_a);
            slope.y += w[k] * static_cast<double>(corner_[k].slope_b);
            start += w[k] * static_cast<double>(corner_[k].start);
        }
        const double depth = at(part_.depth) + t * at(part_.half_depth), stretch = glm::length(slope);
        const glm::uvec3& triangle = sheet_.coverage_.triangles()[beam_];
        glm::dvec3 dimmed(0);
        if (sheet_.coverage_.columns().dims(triangle))
            dimmed = sheet_.coverage_.columns().optical_depth(triangle, w, depth - start);
        const double way = std::max(0.0, (depth - start) * stretch);
        for (int c = 0; c < 3; ++c) dimmed[c] += way * static_cast<double>(medium_.extinction[c]);
        const glm::dvec3 seen(at(segments_.to_a), at(segments_.to_b), at(segments_.to_depth));
        const double sine = 0.5 * glm::length(slope / stretch + seen);
        glm::dvec3 scattered(0);
        for (std::size_t i = 0; i < uneven_->phases.size(); ++i)
            if (scattered_[i] != glm::dvec3(0))
                scattered +=
                    static_cast<double>(uneven_->phases[i].at(static_cast<Real>(sine))) * scattered_[i];
        for (int c = 0; c < 3; ++c)
            light[c] +=
                static_cast<double>(color_[c]) * density * stretch * std::exp(-dimmed[c]) * scattered[c];
    }

    const ScatterSheet<Real>& sheet_;
    const SegmentLanes<Real>& segments_;
    const LightDirection<Real>& direction_;
    const EvenMedium<Real>& medium_;
    const UnevenGroup<Real>* uneven_;
    L (&radiance_)[3];
    L (*target_)[3];  ///< of add_piece: radiance_, or what is to be tested first
    ScatterCounts& counts_;
    Vec3<Real> color_;

    SegmentParts<Real> part_{};
    L middle_{}, half_{};  ///< of the part, m along the segments
    BeamCorner<Real> corner_[3];
    BeamSlices<Real> slices_;
    std::uint32_t beam_ = 0;
    Real flux_ = 0;  ///< of the beam, doubled as its area is
    /// Light of a part of an interval, if nothing stands in its way.
    struct Pair {
        int lane;
        Vec3<Real> light;
        glm::vec3 point, water;  ///< m, world axes relative to the frame's origin
        bool after, before;
    };
    std::vector<Pair> pairs_;
    std::vector<glm::dvec3> scattered_;  ///< a component, of one part
};

template <class Real>
ScatterSheet<Real>::ScatterSheet(const SheetCoverage<Real>& sheet)
    : coverage_(sheet),
      ways_(sheet),
      bounds_(sheet.sheet(), sheet.pyramid(), sheet.triangles(), ways_.last_depths()) {}

template <class Real>
LightDirection<Real> ScatterSheet<Real>::direction(glm::dvec2 disc) const {
    const light::BeamSheet<Real>& sheet = coverage_.sheet();
    return {glm::vec<2, Real>(disc.x * sheet.disc_u + disc.y * sheet.disc_v),
            glm::vec3(coverage_.to_sun(disc))};
}

template <class Real>
glm::dvec3 ScatterSheet<Real>::collapsed() const {
    const light::BeamSheet<Real>& sheet = coverage_.sheet();
    double flux = 0;
    for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
        if (!(sheet.flux[i] > 0)) continue;
        const glm::uvec3& t = coverage_.triangles()[i];
        const auto &p = sheet.rays[t.x], &q = sheet.rays[t.y], &r = sheet.rays[t.z];
        const glm::vec<2, Real> e0(q.a - p.a, q.b - p.b), e1(q.slope_a - p.slope_a, q.slope_b - p.slope_b);
        const glm::vec<2, Real> f0(r.a - p.a, r.b - p.b), f1(r.slope_a - p.slope_a, r.slope_b - p.slope_b);
        const auto cross = [](const glm::vec<2, Real>& x, const glm::vec<2, Real>& y) {
            return x.x * y.y - y.x * x.y;
        };
        if (cross(e0, f0) == 0 && cross(e1, f0) + cross(e0, f1) == 0 && cross(e1, f1) == 0)
            flux += static_cast<double>(sheet.flux[i]);
    }
    return flux * sheet.color;
}

template <class Real>
void ScatterSheet<Real>::corners(std::uint32_t beam, glm::vec<2, Real> shift,
                                 BeamCorner<Real> (&corner)[3]) const {
    const light::BeamSheet<Real>& sheet = coverage_.sheet();
    const glm::uvec3& triangle = coverage_.triangles()[beam];
    for (int k = 0; k < 3; ++k) {
        const auto& ray = sheet.rays[triangle[k]];
        const Real start = sheet.start[triangle[k]];
        corner[k] = {ray.a - start * shift.x, ray.b - start * shift.y, ray.slope_a + shift.x,
                     ray.slope_b + shift.y, start};
    }
}

template <class Real>
SegmentLanes<Real> ScatterSheet<Real>::in_sheet(const SegmentGroup<Real>& group) const {
    const glm::mat<3, 3, Real> world_from_sheet(coverage_.sheet().world_from_mesh);
    const auto along = [&](const Lanes<Real>(&v)[3], int axis) {
        return world_from_sheet[axis].x * v[0] + world_from_sheet[axis].y * v[1] +
               world_from_sheet[axis].z * v[2];
    };
    return {along(group.origin, 0),
            along(group.origin, 1),
            along(group.origin, 2),
            along(group.direction, 0),
            along(group.direction, 1),
            along(group.direction, 2),
            group.length};
}

template <class Real>
void ScatterSheet<Real>::add(const SegmentGroup<Real>& segments, const LightDirection<Real>& direction,
                             const EvenMedium<Real>& medium, const UnevenGroup<Real>* uneven,
                             Lanes<Real> (&radiance)[3], ScatterCounts& counts) const {
    if (coverage_.pyramid().empty()) return;
    SegmentLanes<Real> lanes = in_sheet(segments);
    if (medium.least > 0) lanes.length = lesser(lanes.length, splat(Real(kOpaque) / medium.least));
    if (uneven) {
        for (int lane = 0; lane < kLanes<Real>; ++lane) {
            if (!uneven->uneven[lane]) continue;
            const SegmentScatter& scatter = uneven->scatter[lane];
            // A little more: what is taken is cut by the scattering itself.
            lanes.first[lane] = static_cast<Real>(scatter.first()) * (1 - Real(1e-6));
            lanes.length[lane] = scatter.first() < scatter.last()
                                     ? static_cast<Real>(scatter.last()) * (1 + Real(1e-6))
                                     : Real(-1);
        }
    }
    ScatterQuery<Real>(*this, lanes, direction, medium, uneven, radiance, counts).run();
}

template class ScatterSheet<float>;
template class ScatterSheet<double>;

}  // namespace dapple::methods::sliced_beams
