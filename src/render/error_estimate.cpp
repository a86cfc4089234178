#include "render/error_estimate.h"

#include <algorithm>
#include <cmath>

namespace dapple::render {

double relative_difference(const PixelIrradiance& a, const PixelIrradiance& b) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        if (a.covered[i] == 0 || b.covered[i] == 0) continue;
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = static_cast<double>(b.values[i][channel]);
            difference += std::abs(static_cast<double>(a.values[i][channel]) - expected);
            sum += expected;
        }
    }
    return sum > 0 ? difference / sum : 0;
}

Convergence convergence(double d01, double d12, double d02) {
    if (d02 == 0 && d12 == 0) return {0, 0.5};
    if (!(d12 < d01)) return {HUGE_VAL, 1};
    const double r = d12 / d01;
    const double square = (d02 * d02 - r * d01 * d01) / ((1 - r) * (1 - r * r * r));
    const double error = std::sqrt(std::max(0.0, square));
    return {std::clamp(error, d02 / (1 + r * r), d02 / (1 - r * r)), r};
}

void ErrorCurve::add(double resolution, double error) {
    const auto finer = std::find_if(points_.begin(), points_.end(),
                                    [&](const Point& point) { return point.resolution > resolution; });
    points_.insert(finer, {resolution, error});
}

double ErrorCurve::order(std::size_t i) const {
    const Point& from = points_[i];
    const Point& to = points_[i + 1];
    if (to.error == 0) return HUGE_VAL;
    return std::log(from.error / to.error) / std::log(to.resolution / from.resolution);
}

double ErrorCurve::at(double resolution) const {
    if (points_.empty() || resolution < points_.front().resolution) return HUGE_VAL;
    std::size_t i = 0;
    while (i + 1 < points_.size() && points_[i + 1].resolution <= resolution) ++i;
    const Point& point = points_[i];
    if (resolution == point.resolution || points_.size() == 1 || point.error == 0) return point.error;
    const double fall = order(std::min(i, points_.size() - 2));
    return std::isfinite(fall) ? point.error * std::pow(point.resolution / resolution, fall) : point.error;
}

double ErrorCurve::resolution_for(double error) const {
    if (points_.empty()) return HUGE_VAL;
    const Point& finest = points_.back();
    if (finest.error > error) {
        const double fall = points_.size() > 1 ? order(points_.size() - 2) : 0;
        return fall > 0 ? finest.resolution * std::pow(finest.error / error, 1 / fall) : HUGE_VAL;
    }
    std::size_t i = points_.size() - 1;
    while (i > 0 && points_[i - 1].error <= error) --i;
    if (i == 0) return points_.front().resolution;
    const Point& coarser = points_[i - 1];
    if (!std::isfinite(coarser.error)) return points_[i].resolution;
    return coarser.resolution * std::pow(coarser.error / error, 1 / order(i - 1));
}

}  // namespace dapple::render
