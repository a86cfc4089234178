#include "timeline/curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace dapple::timeline {
namespace {

/// Slope at a key between two segments of widths h and secants d: the weighted harmonic mean of Fritsch and
/// Butland
/// ("A method for constructing local monotone piecewise cubic interpolants", 1984), 0 at an extremum.
double inner_slope(double h0, double d0, double h1, double d1) {
    if (d0 * d1 <= 0) return 0;
    const double w0 = 2 * h1 + h0;
    const double w1 = h1 + 2 * h0;
    return (w0 + w1) / (w0 / d0 + w1 / d1);
}

/// Slope at the outer end of a segment (h0, d0) whose neighbour is (h1, d1): that of the parabola through the
/// three keys, limited so that the segment stays monotone (Fritsch and Carlson, 1980: at most three times the
/// secant).
double end_slope(double h0, double d0, double h1, double d1) {
    const double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if (slope * d0 <= 0) return 0;
    return std::abs(slope) > 3 * std::abs(d0) ? 3 * d0 : slope;
}

double hermite(double u, double width, double a, double b, double slope_a, double slope_b) {
    const double v = 1 - u;
    const double value =
        v * v * (1 + 2 * u) * a + u * u * (1 + 2 * v) * b + u * v * width * (v * slope_a - u * slope_b);
    return std::clamp(value, std::min(a, b), std::max(a, b));  // monotone also in its last bit
}

/// A coordinate of the cubic Bezier curve from 0 to 1 with inner control values p and q.
double bezier(double s, double p, double q) {
    const double r = 1 - s;
    return 3 * r * r * s * p + 3 * r * s * s * q + s * s * s;
}

/// Parameter s at which the Bezier's x is `x`: Newton's steps, kept in a bracket that halves where they leave
/// it. With p and q in [0, 1] x(s) is monotone, so there is one root.
double bezier_parameter(double x, double p, double q) {
    double low = 0;
    double high = 1;
    double s = x;
    for (int i = 0; i < 64; ++i) {
        const double error = bezier(s, p, q) - x;
        if (error == 0) break;
        (error < 0 ? low : high) = s;
        const double r = 1 - s;
        const double slope = 3 * r * r * p + 6 * r * s * (q - p) + 3 * s * s * (1 - q);
        double next = slope > 0 ? s - error / slope : low;
        if (!(next > low && next < high)) next = (low + high) / 2;
        if (next == s) break;
        s = next;
    }
    return s;
}

}  // namespace

Curve::Curve(std::vector<Key> keys, std::size_t components)
    : keys_(std::move(keys)), components_(components), slopes_(2 * keys_.size()) {
    assert(!keys_.empty() && components_ >= 1 && components_ <= 3);
    const auto is_cubic = [&](std::size_t i) {
        return i + 1 < keys_.size() && keys_[i].interpolation == Interpolation::cubic;
    };
    const auto width = [&](std::size_t i) { return keys_[i + 1].time - keys_[i].time; };
    for (std::size_t i = 0; i + 1 < keys_.size(); ++i) {
        if (!is_cubic(i)) continue;
        // Only cubic neighbours matter: what a step or an ease does beside it says nothing of this segment's
        // slope.
        const bool left = i > 0 && is_cubic(i - 1);
        const bool right = is_cubic(i + 1);
        for (std::size_t c = 0; c < components_; ++c) {
            const auto secant = [&](std::size_t k) {
                return (keys_[k + 1].values[c] - keys_[k].values[c]) / width(k);
            };
            const double d = secant(i);
            double begin = d;
            double end = d;
            if (left)
                begin = inner_slope(width(i - 1), secant(i - 1), width(i), d);
            else if (right)
                begin = end_slope(width(i), d, width(i + 1), secant(i + 1));
            if (right)
                end = inner_slope(width(i), d, width(i + 1), secant(i + 1));
            else if (left)
                end = end_slope(width(i), d, width(i - 1), secant(i - 1));
            slopes_[2 * i][c] = begin;
            slopes_[2 * i + 1][c] = end;
        }
    }
}

Values Curve::at(double time) const {
    const auto after = std::upper_bound(keys_.begin(), keys_.end(), time,
                                        [](double t, const Key& key) { return t < key.time; });
    if (after == keys_.begin()) return keys_.front().values;
    const auto i = static_cast<std::size_t>(after - keys_.begin()) - 1;
    const Key& key = keys_[i];
    if (after == keys_.end() || time == key.time || key.interpolation == Interpolation::step)
        return key.values;

    const Key& next = *after;
    const double width = next.time - key.time;
    const double u = (time - key.time) / width;
    double share = u;
    if (key.interpolation == Interpolation::bezier)
        share = bezier(bezier_parameter(u, key.out.x, next.in.x), key.out.y, next.in.y);
    Values values{};
    for (std::size_t c = 0; c < components_; ++c) {
        const double a = key.values[c];
        const double b = next.values[c];
        values[c] = key.interpolation == Interpolation::cubic
                        ? hermite(u, width, a, b, slopes_[2 * i][c], slopes_[2 * i + 1][c])
                        : a + (b - a) * share;
    }
    return values;
}

}  // namespace dapple::timeline
