#include "methods/sliced_beams/scatter_sheet.h"

#include <algorithm>
#include <cmath>

#include "methods/sliced_beams/exponential.h"
#include "methods/sliced_beams/segment_quadrature.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Optical depth of an interval that three nodes are enough for: relative error of the integral of e^-x, 2e-7
/// in float, 4e-10 in double.
template <class Real>
constexpr Real kThinEnough = sizeof(Real) == 4 ? Real(1) : Real(0.35);
/// Light beyond so many optical depths, e^-60 of it, is left out.
constexpr double kOpaque = 60;

}  // namespace

void ScatterCounts::add(const ScatterCounts& other) {
    clusters += other.clusters;
    beams += other.beams;
    intervals += other.intervals;
    peaks += other.peaks;
    foci += other.foci;
    dropped += other.dropped;
}

void ScatterCounts::report(FrameStats& stats) const {
    stats.count("segments times clusters", static_cast<double>(clusters));
    stats.count("segments times beams", static_cast<double>(beams));
    stats.count("intervals in beams", static_cast<double>(intervals));
    stats.count("intervals that peak", static_cast<double>(peaks));
    if (foci > 0) stats.count("intervals through foci", static_cast<double>(foci));
    if (dropped > 0) stats.count("lost to scattering not finite, W/m^2/sr", dropped);
}

/// One query of a ScatterSheet.
template <class Real>
class ScatterQuery {
public:
    using L = Lanes<Real>;
    using Vec2 = glm::vec<2, Real>;

    ScatterQuery(const ScatterSheet<Real>& sheet, const SegmentLanes<Real>& segments, Vec2 shift,
                 const EvenMedium<Real>& medium, L (&radiance)[3], ScatterCounts& counts)
        : sheet_(sheet),
          segments_(segments),
          shift_(shift),
          medium_(medium),
          radiance_(radiance),
          counts_(counts),
          color_(sheet.coverage_.sheet().color) {}

    void run() {
        const BeamPyramid<Real>& pyramid = sheet_.coverage_.pyramid();
        sheet_.bounds_.visit(segments_, shift_,
                             [&](typename BeamPyramid<Real>::NodeId node, const L& from, const L& to) {
                                 const Mask<Real> met = from <= to;
                                 counts_.clusters += static_cast<std::size_t>(__builtin_popcount(bits(met)));
                                 take_part(from, to, met);
                                 for (const std::uint32_t beam : pyramid.beams(node)) add_beam(beam, met);
                             });
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
        counts_.beams += static_cast<std::size_t>(kLanes<Real>);
        sheet_.corners(beam, shift_, corner_);
        slices_ = slices(corner_, part_);
        visit_pieces(slices_, met, [&](const L& enter, const L& leave, const Mask<Real>& mask) {
            counts_.intervals += static_cast<std::size_t>(__builtin_popcount(bits(mask)));
            add_piece(2 * sheet.flux[beam], enter, leave, mask);
        });
    }

    /// The ray through a point of the beam.
    struct Node {
        L path;     ///< m from the water to the point, and back to the segment's near end
        L stretch;  ///< m of way a m of depth
        L sine;     ///< of half the angle between the ways before and after
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
        const L slope_a = mix(c0.slope_a, c1.slope_a, c2.slope_a);
        const L slope_b = mix(c0.slope_b, c1.slope_b, c2.slope_b);
        const L start = mix(c0.start, c1.start, c2.start);
        const L depth = multiply_add(t, part_.half_depth, part_.depth);
        Node n;
        n.stretch =
            square_root<Real>(multiply_add(slope_a, slope_a, multiply_add(slope_b, slope_b, splat(Real(1)))));
        n.path = multiply_add(depth - start, n.stretch, multiply_add(t, half_, middle_));
        if (!medium_.phase->even()) {
            // |before - after| / 2: half the angle between unit vectors loses no digits so.
            const L unit = splat(Real(1)) / n.stretch;
            const L a = multiply_add(slope_a, unit, segments_.to_a);
            const L b = multiply_add(slope_b, unit, segments_.to_b);
            const L d = unit + segments_.to_depth;
            n.sine = Real(0.5) * square_root<Real>(a * a + b * b + d * d);
        }
        return n;
    }

    void add_piece(Real doubled_flux, const L& enter, const L& leave, const Mask<Real>& mask) {
        // Optical depth may be too much for one rule.
        const L from = node(enter).path, to = node(leave).path;
        const L change = mask ? magnitude(to - from) * medium_.most : L{};
        Real most = 0;
        for (int lane = 0; lane < kLanes<Real>; ++lane) most = std::max(most, change[lane]);
        if (most <= kThinEnough<Real>) return add_thin(doubled_flux, enter, leave, mask);
        add_thick(doubled_flux, enter, leave, from, to, mask);
    }

    /// Cut where nothing is left of the light, and into parts.
    void add_thick(Real doubled_flux, L enter, L leave, const L& from, const L& to, const Mask<Real>& mask) {
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
            add_thin(doubled_flux, before, after, mask);
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

    void add_thin(Real doubled_flux, const L& enter, const L& leave, const Mask<Real>& mask) {
        const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
        L weight[3];
        weigh(middle, half, mask, weight);
        Node nodes[3];
        for (int j = 0; j < 3; ++j) nodes[j] = node(multiply_add(half, splat(Real(kNodes[j])), middle));
        const L scale = half * half_ * doubled_flux;
        for (int j = 0; j < 3; ++j) weight[j] *= scale * nodes[j].stretch * (*medium_.phase)(nodes[j].sine);
        for (int channel = 0; channel < 3; ++channel) {
            const Real extinction = medium_.extinction[channel];
            L sum = weight[1] * decay(greater(extinction * nodes[1].path, L{}));
            sum += weight[0] * decay(greater(extinction * nodes[0].path, L{}));
            sum += weight[2] * decay(greater(extinction * nodes[2].path, L{}));
            sum *= medium_.scattering[channel] * color_[channel];
            const auto finite = (sum - sum) == 0;
            const Mask<Real> lost = mask & ~finite;
            if (any(lost)) counts_.dropped += 1;
            radiance_[channel] += mask & finite ? sum : L{};
        }
    }

    const ScatterSheet<Real>& sheet_;
    const SegmentLanes<Real>& segments_;
    Vec2 shift_;
    const EvenMedium<Real>& medium_;
    L (&radiance_)[3];
    ScatterCounts& counts_;
    Vec3<Real> color_;

    SegmentParts<Real> part_{};
    L middle_{}, half_{};  ///< of the part, m along the segments
    BeamCorner<Real> corner_[3];
    BeamSlices<Real> slices_;
};

template <class Real>
ScatterSheet<Real>::ScatterSheet(const SheetCoverage<Real>& sheet)
    : coverage_(sheet), bounds_(sheet.sheet(), sheet.pyramid(), sheet.triangles(), {}) {}

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
void ScatterSheet<Real>::add(const SegmentGroup<Real>& segments, glm::vec<2, Real> shift,
                             const EvenMedium<Real>& medium, Lanes<Real> (&radiance)[3],
                             ScatterCounts& counts) const {
    if (coverage_.pyramid().empty()) return;
    SegmentLanes<Real> lanes = in_sheet(segments);
    if (medium.least > 0) lanes.length = lesser(lanes.length, splat(Real(kOpaque) / medium.least));
    ScatterQuery<Real>(*this, lanes, shift, medium, radiance, counts).run();
}

template class ScatterSheet<float>;
template class ScatterSheet<double>;

}  // namespace dapple::methods::sliced_beams
