#include "judge/defects_drift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dapple::judge {
namespace {

constexpr double kMostCorrelation = 0.98;

}  // namespace

std::optional<Drift> find_drift(const std::vector<std::pair<std::int64_t, double>>& errors,
                                const std::vector<std::int64_t>& jumps) {
    const std::size_t count = errors.size();
    if (count < kLeastDriftFrames) return std::nullopt;
    // The series with the jumps' own changes taken out.
    std::vector<double> x, y;
    double taken_out = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (i > 0 && std::ranges::find(jumps, errors[i].first) != jumps.end()) {
            taken_out += errors[i].second - errors[i - 1].second;
        }
        x.push_back(static_cast<double>(errors[i].first));
        y.push_back(errors[i].second - taken_out);
    }
    const auto n = static_cast<double>(count);
    double mean_x = 0, mean_y = 0;
    for (std::size_t i = 0; i < count; ++i) {
        mean_x += x[i] / n;
        mean_y += y[i] / n;
    }
    double xx = 0, xy = 0;
    for (std::size_t i = 0; i < count; ++i) {
        xx += (x[i] - mean_x) * (x[i] - mean_x);
        xy += (x[i] - mean_x) * (y[i] - mean_y);
    }
    const double slope = xy / xx;
    double squares = 0, neighbours = 0, before = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double residual = y[i] - mean_y - slope * (x[i] - mean_x);
        squares += residual * residual;
        if (i > 0) neighbours += residual * before;
        before = residual;
    }
    // Variance of the slope; of a first-order autoregressive scatter (1 + r) / (1 - r) times as large. Of few
    // residuals r is uncertain, by 1 / sqrt(n), and too small, by about (2 + 4 r) / n, as the line follows
    // the scatter: two standard errors more are taken, and what is missing.
    const double estimate = squares > 0 ? neighbours / squares : 0;
    const double correlation =
        std::clamp(estimate + (2 + 4 * estimate) / n + 2 / std::sqrt(n), 0.0, kMostCorrelation);
    const double variance = squares / (n - 2) / xx * (1 + correlation) / (1 - correlation);
    const double total = slope * (x.back() - x.front());
    if (std::abs(total) < kLeastDrift || slope * slope < kDriftSigma * kDriftSigma * variance) {
        return std::nullopt;
    }
    return Drift{slope, total};
}

}  // namespace dapple::judge
