// The light of one interval of a segment in a beam: the rest of ScatterQuery.
#include <algorithm>
#include <cmath>
#include <limits>

#include "methods/sliced_beams/scatter_query.h"
#include "methods/sliced_beams/segment_quadrature.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Optical depth of an interval that three nodes are enough for: relative error of the integral of e^-x, 2e-7
/// in float, 4e-10 in double.
template <class Real>
constexpr Real kThinEnough = sizeof(Real) == 4 ? Real(1) : Real(0.35);
/// Where two nodes are as good: change of the area on the interval, relative, and optical depth.
constexpr double kTwoNodesEven = 0.1, kTwoNodesThin = 0.25;
/// Optical depth about the mean that the moments hold for: by that to the fifth over 120, 8e-8 in float,
/// 8e-13 in double, their series of e^-x is off.
template <class Real>
constexpr Real kSmooth = sizeof(Real) == 4 ? Real(0.1) : Real(0.01);

}  // namespace

template <class Real>
typename ScatterQuery<Real>::BeamRay ScatterQuery<Real>::ray(const L& t) const {
    const L w0 = magnitude((*edge_[0])(t)), w1 = magnitude((*edge_[1])(t)), w2 = magnitude((*edge_[2])(t));
    const L whole = w0 + w1 + w2;
    const auto thin = whole == 0;
    const L scale = splat(Real(1)) / (thin ? splat(Real(1)) : whole);
    return mixed(thin ? splat(Real(1) / 3) : w1 * scale, thin ? splat(Real(1) / 3) : w2 * scale);
}

/// Near a focus edges lose the digits that the area has: no share may leave [0, 1] for it.
template <class Real>
typename ScatterQuery<Real>::BeamRay ScatterQuery<Real>::ray(const L& t, const L& inverse_area) const {
    const L one = splat(Real(1));
    return mixed(lesser(magnitude((*edge_[1])(t)) * inverse_area, one),
                 lesser(magnitude((*edge_[2])(t)) * inverse_area, one));
}

template <class Real>
typename ScatterQuery<Real>::BeamRay ScatterQuery<Real>::mixed(const L& l1, const L& l2) const {
    const auto mix = [&](Real v0, Real v1, Real v2) {
        return multiply_add(l1, splat(v1 - v0), multiply_add(l2, splat(v2 - v0), splat(v0)));
    };
    const auto& [c0, c1, c2] = corner_;
    return {mix(c0.slope_a, c1.slope_a, c2.slope_a),
            mix(c0.slope_b, c1.slope_b, c2.slope_b),
            mix(c0.start, c1.start, c2.start),
            {splat(Real(1)) - l1 - l2, l1, l2}};
}

template <class Real>
typename ScatterQuery<Real>::Node ScatterQuery<Real>::node(const L& t, const BeamRay& r) const {
    Node n;
    const L depth = multiply_add(t, part_.half_depth, part_.depth);
    const L squared = multiply_add(r.slope_a, r.slope_a, multiply_add(r.slope_b, r.slope_b, splat(Real(1))));
    n.stretch = square_root<Real>(squared);
    n.path = multiply_add(depth - r.start, n.stretch, multiply_add(t, half_, middle_));
    if (!medium_.phase->even()) {
        // |before - after| / 2: half the angle between unit vectors loses no digits so.
        const L unit = inverse_root(squared);
        const L a = multiply_add(r.slope_a, unit, segments_.to_a);
        const L b = multiply_add(r.slope_b, unit, segments_.to_b);
        const L d = unit + segments_.to_depth;
        n.squared_sine = Real(0.25) * multiply_add(a, a, multiply_add(b, b, d * d));
    }
    return n;
}

template <class Real>
void ScatterQuery<Real>::add_piece(const L& enter, const L& leave, Mask<Real> mask) {
    if (uneven_) {
        const bool dimmed = sheet_.coverage_.columns().dims(beam_);
        const Mask<Real> uneven = dimmed ? mask : mask & uneven_->uneven;
        if (any(uneven)) add_uneven(enter, leave, uneven);
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

template <class Real>
void ScatterQuery<Real>::add_thick(L enter, L leave, const L& from, const L& to, const Mask<Real>& mask) {
    L way = magnitude(to - from);
    if (medium_.least > 0) {
        const L least = lesser(from, to);
        const L seen = splat(Real(media::kOpaque) / medium_.least) - greater(least, L{});
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

template <class Real>
void ScatterQuery<Real>::weigh(const L& middle, const L& half, const Mask<Real>& mask, L (&weight)[3]) {
    const auto [q0, q1, q2] = part_of(area_, middle, half);
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

template <class Real>
void ScatterQuery<Real>::add_thin(const L& enter, const L& leave, const Mask<Real>& mask) {
    const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    L weight[3];
    weigh(middle, half, mask, weight);
    Node nodes[3];
    for (int j = 0; j < 3; ++j) nodes[j] = node(multiply_add(half, splat(Real(kNodes[j])), middle));
    sum_up(nodes, weight, half, mask);
}

template <class Real>
bool ScatterQuery<Real>::weigh_even(const L& middle, const L& half, const Mask<Real>& mask, Node (&nodes)[2],
                                    L (&weight)[2]) {
    const auto [q0, q1, q2] = part_of(area_, middle, half);
    if (any(mask & ~(magnitude(q1) + Real(10) * magnitude(q2) <= Real(kTwoNodesEven) * magnitude(q0))))
        return false;
    constexpr Real u = Real(0.5773502691896258);  // Gauss & Legendre's rule, exact for degree three
    const L even = multiply_add(q2, splat(u * u), q0);
    const L place[2] = {middle - u * half, middle + u * half};
    weight[0] = Real(1) / magnitude(even - u * q1);
    weight[1] = Real(1) / magnitude(even + u * q1);
    for (int j = 0; j < 2; ++j) nodes[j] = node(place[j], ray(place[j], weight[j]));
    return true;
}

template <class Real>
bool ScatterQuery<Real>::add_even(const L& enter, const L& leave, const Mask<Real>& mask) {
    const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    Node nodes[2];
    L weight[2];
    if (!weigh_even(middle, half, mask, nodes, weight)) return false;
    const L change = magnitude(nodes[1].path - nodes[0].path) * (medium_.most * Real(1.7320508));
    if (any(mask & ~(change <= Real(kTwoNodesThin)))) return false;
    sum_up(nodes, weight, half, mask);
    return true;
}

template <class Real>
bool ScatterQuery<Real>::begin_moments(const BeamCluster<Real>& cluster, const Mask<Real>& met) {
    if (uneven_ || !sheet_.coverage_.sheet().tint.empty()) return false;
    const Real lean = std::abs(direction_.shift.x) + std::abs(direction_.shift.y);
    const Real start = Real(0.5) * (cluster.first_start + cluster.last_start);
    const Real stretch = Real(0.5) * (cluster.least_stretch + cluster.most_stretch);
    const Real most = cluster.most_stretch + lean;
    const L below = part_.depth - start;
    const L off = multiply_add(magnitude(below), splat(most - stretch),
                               multiply_add(magnitude(part_.half_depth), splat(most), half_)) +
                  (cluster.last_start - start) * most;
    if (any(met & (off * medium_.most > kSmooth<Real>))) return false;
    const L path = greater(multiply_add(below, splat(stretch), middle_), L{});
    const L all_off = off + magnitude(path - mean_path_);
    if (any(met & has_moments_ & (all_off * medium_.most > kSmooth<Real>))) settle_moments();
    mean_path_ = has_moments_ ? mean_path_ : path;
    has_moments_ |= met;
    return true;
}

template <class Real>
void ScatterQuery<Real>::add_moments(const L& enter, const L& leave, const Mask<Real>& mask) {
    const L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    if constexpr (sizeof(Real) == 4) {
        Node nodes[2];
        L weight[2];
        if (weigh_even(middle, half, mask, nodes, weight)) return gather(nodes, weight, half, mask);
    }
    Node nodes[3];
    L weight[3];
    weigh(middle, half, mask, weight);
    for (int j = 0; j < 3; ++j) nodes[j] = node(multiply_add(half, splat(Real(kNodes[j])), middle));
    gather(nodes, weight, half, mask);
}

template <class Real>
template <int kCount>
void ScatterQuery<Real>::gather(const Node (&nodes)[kCount], const L (&weight)[kCount], const L& half,
                                const Mask<Real>& mask) {
    const L scale = half * half_ * flux_;
    for (int j = 0; j < kCount; ++j) {
        const Node& n = nodes[j];
        L light = weight[j] * scale * n.stretch * (*medium_.phase)(n.squared_sine);
        const auto finite = light <= std::numeric_limits<Real>::max();
        if (any(mask & ~finite))
            counts_.dropped += 3 * static_cast<std::size_t>(__builtin_popcount(bits(mask & ~finite)));
        light = (mask & finite) ? light : L{};
        const L off = n.path - mean_path_;
        moments_[0] += light;
        for (int i = 1; i < kMoments; ++i) {
            light *= off;
            moments_[i] += light;
        }
    }
}

template <class Real>
void ScatterQuery<Real>::settle_moments() {
    for (int channel = 0; channel < 3; ++channel) {
        // e^-(x + y) = e^-x (1 - y (1 - y / 2 (1 - ...)))
        const Real extinction = medium_.extinction[channel];
        L sum = moments_[kMoments - 1];
        for (int i = kMoments - 1; i > 0; --i)
            sum = multiply_add(sum, splat(-extinction / static_cast<Real>(i)), moments_[i - 1]);
        const Real scale = medium_.scattering[channel] * color_[channel];
        radiance_[channel] += scale * decay(extinction * mean_path_) * sum;
    }
    for (L& moment : moments_) moment = L{};
    has_moments_ = Mask<Real>{};
}

template <class Real>
template <int kCount>
void ScatterQuery<Real>::sum_up(const Node (&nodes)[kCount], L (&weight)[kCount], const L& half,
                                const Mask<Real>& mask) {
    const L scale = half * half_ * flux_;
    for (int j = 0; j < kCount; ++j)
        weight[j] *= scale * nodes[j].stretch * (*medium_.phase)(nodes[j].squared_sine);
    for (int channel = 0; channel < 3; ++channel) {
        const Real extinction = medium_.extinction[channel];
        L sum{};
        for (int j = 0; j < kCount; ++j) sum += weight[j] * decay(greater(extinction * nodes[j].path, L{}));
        sum *= medium_.scattering[channel] * color_[channel];
        const auto finite = magnitude(sum) <= std::numeric_limits<Real>::max();
        counts_.dropped += static_cast<std::size_t>(__builtin_popcount(bits(mask & ~finite)));
        (*target_)[channel] += (mask & finite) ? sum : L{};
    }
}

template void ScatterQuery<float>::add_piece(const L&, const L&, Mask<float>);
template void ScatterQuery<double>::add_piece(const L&, const L&, Mask<double>);
template bool ScatterQuery<float>::begin_moments(const BeamCluster<float>&, const Mask<float>&);
template bool ScatterQuery<double>::begin_moments(const BeamCluster<double>&, const Mask<double>&);
template void ScatterQuery<float>::add_moments(const L&, const L&, const Mask<float>&);
template void ScatterQuery<double>::add_moments(const L&, const L&, const Mask<double>&);
template void ScatterQuery<float>::settle_moments();
template void ScatterQuery<double>::settle_moments();
template typename ScatterQuery<float>::BeamRay ScatterQuery<float>::ray(const L&) const;
template typename ScatterQuery<double>::BeamRay ScatterQuery<double>::ray(const L&) const;

}  // namespace dapple::methods::sliced_beams
