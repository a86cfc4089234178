// The light of one interval of a segment in a beam, where bounded media scatter or dim it: a part of
// ScatterQuery.
#include <algorithm>
#include <cmath>
#include <limits>

#include "methods/sliced_beams/scatter_query.h"
#include "methods/sliced_beams/segment_quadrature.h"

namespace dapple::methods::sliced_beams {
namespace {

/// Change of the beam's area on an interval, relative, up to which it is taken as a whole: two nodes are good
/// to 1e-5 for the mean of one over the area then, and what is lost by not weighing it by what is scattered
/// there is below 1e-3.
constexpr double kEvenArea = 0.1;
/// Pieces of W on such an interval, at most, and optical depth: light on its way loses about as much, and to
/// take it at the centroid is off by the square of that over 24.
constexpr std::size_t kMostPieces = 4;
constexpr float kMostDepth = 0.1f;

}  // namespace

template <class Real>
void ScatterQuery<Real>::add_uneven(const L& enter, const L& leave, Mask<Real> mask) {
    if constexpr (sizeof(Real) == 4) mask &= ~add_whole(enter, leave, mask);
    for (unsigned lanes = bits(mask); lanes != 0; lanes &= lanes - 1)
        add_pieces(enter, leave, __builtin_ctz(lanes));
}

template <class Real>
Mask<Real> ScatterQuery<Real>::add_whole(const L& enter, const L& leave, const Mask<Real>& mask) {
    L middle = Real(0.5) * (enter + leave), half = Real(0.5) * (leave - enter);
    const auto [q0, q1, q2] = part_of(area_, middle, half);
    Mask<Real> taken = mask & (magnitude(q1) + Real(3) * magnitude(q2) <= Real(kEvenArea) * magnitude(q0));
    if (!any(taken)) return taken;
    constexpr Real u = Real(0.5773502691896258);  // Gauss & Legendre's rule, exact for degree three
    const L even = multiply_add(q2, splat(u * u), q0);
    const L density =
        flux_ * Real(0.5) * (Real(1) / magnitude(even - u * q1) + Real(1) / magnitude(even + u * q1));

    // What is scattered in the two halves, m along the segments.
    const L from = multiply_add(half_, enter, middle_), to = multiply_add(half_, leave, middle_);
    L before{}, after{}, first{}, size{};
    Mask<Real> lit{};
    std::fill(whole_.begin(), whole_.end(), ChannelLanes{});
    for (unsigned lanes = bits(taken); lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const SegmentScatter& scatter = uneven_->scatter[lane];
        const float begin = std::max(from[lane], static_cast<float>(scatter.first()));
        const float end = std::min(to[lane], static_cast<float>(scatter.last()));
        if (!(begin < end)) continue;
        const std::size_t piece = piece_[lane] = scatter.piece(begin, piece_[lane]);
        if (!scatter.is_short(piece, begin, end, kMostPieces, kMostDepth)) {
            taken[lane] = 0;
            continue;
        }
        const float centre = 0.5f * (begin + end);
        for (std::size_t i = 0; i < whole_.size(); ++i) {
            std::size_t at = piece;
            const SegmentScatter::Channels early = scatter.scattered(i, at, begin, centre);
            const SegmentScatter::Channels late = scatter.scattered(i, at, centre, end);
            for (int c = 0; c < 3; ++c) whole_[i].channel[c][lane] = early[c] + late[c];
            before[lane] += early[3];
            after[lane] += late[3];
        }
        first[lane] = begin;
        size[lane] = end - begin;
        lit[lane] = before[lane] + after[lane] > 0 ? -1 : 0;
    }
    if (!any(lit)) return taken;

    // The rest is taken at the centroid.
    const L off = (after - before) / (lit ? before + after : splat(Real(1)));
    const L place = multiply_add(size, Real(0.5) + Real(1) / 3 * off, first);
    const L t = lit ? (place - middle_) / half_ : L{};
    const BeamRay r = ray(t);
    const L below = multiply_add(t, part_.half_depth, part_.depth) - r.start;
    const L squared = multiply_add(r.slope_a, r.slope_a, multiply_add(r.slope_b, r.slope_b, splat(Real(1))));
    const L stretch = square_root<Real>(squared), unit = Real(1) / stretch;
    const L a = multiply_add(r.slope_a, unit, segments_.to_a);
    const L b = multiply_add(r.slope_b, unit, segments_.to_b);
    const L d = unit + segments_.to_depth;
    const L squared_sine = Real(0.25) * multiply_add(a, a, multiply_add(b, b, d * d));
    L dimmed[3] = {};
    const RayColumns<Real>& columns = sheet_.coverage_.columns();
    if (columns.dims(beam_)) columns.add_optical_depth(beam_, r.share, below, direction_.shift, lit, dimmed);
    const L way = greater(below * stretch, L{});
    L light[3] = {};
    for (std::size_t i = 0; i < whole_.size(); ++i) {
        const L phase = uneven_->phases[i](squared_sine);
        for (int c = 0; c < 3; ++c) light[c] = multiply_add(phase, whole_[i].channel[c], light[c]);
    }
    const L scale = density * stretch;
    for (int c = 0; c < 3; ++c) {
        const L sum =
            color_[c] * scale * decay(multiply_add(way, splat(medium_.extinction[c]), dimmed[c])) * light[c];
        const Mask<Real> finite = magnitude(sum) <= std::numeric_limits<Real>::max();
        counts_.dropped += static_cast<std::size_t>(__builtin_popcount(bits(lit & ~finite)));
        (*target_)[c] += (lit & finite) ? sum : L{};
    }
    return taken;
}

template <class Real>
void ScatterQuery<Real>::add_pieces(const L& enter, const L& leave, int lane) {
    const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
    const SegmentScatter& scatter = uneven_->scatter[lane];
    const std::span<const double> places = scatter.places();
    const double middle = at(middle_), half = at(half_);
    const double first = std::max(middle + half * at(enter), scatter.first());
    const double last = std::min(middle + half * at(leave), scatter.last());
    if (!(first < last)) return;
    auto piece =
        static_cast<std::size_t>(std::upper_bound(places.begin(), places.end(), first) - places.begin()) - 1;
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

template <class Real>
void ScatterQuery<Real>::add_part(const SegmentScatter& scatter, std::size_t piece, double from, double to,
                                  int lane, double (&light)[3]) {
    const auto at = [lane](const L& v) { return static_cast<double>(v[lane]); };
    const double middle = at(middle_), scale = 1 / at(half_);
    double t = (0.5 * (from + to) - middle) * scale;
    const double half = 0.5 * (to - from) * scale;
    const auto value = [&](const Quadratic<Real>& q) { return at(q.c0) + t * (at(q.c1) + t * at(q.c2)); };
    // Integral over [-1, 1] of one over the area.
    const double q0 = value(area_);
    const double q1 = half * (at(area_.c1) + 2 * t * at(area_.c2));
    const double q2 = half * half * at(area_.c2);
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
    glm::dvec3 w = glm::abs(glm::dvec3(value(*edge_[0]), value(*edge_[1]), value(*edge_[2])));
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
    glm::dvec3 dimmed(0);
    if (sheet_.coverage_.columns().dims(beam_))
        dimmed = sheet_.coverage_.columns().optical_depth(beam_, w, depth - start, direction_.shift);
    const double way = std::max(0.0, (depth - start) * stretch);
    for (int c = 0; c < 3; ++c) dimmed[c] += way * static_cast<double>(medium_.extinction[c]);
    const glm::dvec3 seen(at(segments_.to_a), at(segments_.to_b), at(segments_.to_depth));
    const glm::dvec3 turn = slope / stretch + seen;
    const double squared_sine = 0.25 * glm::dot(turn, turn);
    glm::dvec3 scattered(0);
    for (std::size_t i = 0; i < uneven_->phases.size(); ++i)
        if (scattered_[i] != glm::dvec3(0))
            scattered +=
                static_cast<double>(uneven_->phases[i].at(static_cast<Real>(squared_sine))) * scattered_[i];
    for (int c = 0; c < 3; ++c)
        light[c] += static_cast<double>(color_[c]) * density * stretch * std::exp(-dimmed[c]) * scattered[c];
}

template void ScatterQuery<float>::add_uneven(const L&, const L&, Mask<float>);
template void ScatterQuery<double>::add_uneven(const L&, const L&, Mask<double>);

}  // namespace dapple::methods::sliced_beams
