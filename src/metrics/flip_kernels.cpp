#include "metrics/flip_kernels.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace dapple::metrics {
namespace {

using Weights = std::vector<double>;  ///< at distances 0, 1, ...

/// Of a symmetric kernel, over both sides.
double sum(const Weights& weights) {
    double sides = 0;
    for (std::size_t k = 1; k < weights.size(); ++k) sides += weights[k];
    return weights[0] + 2 * sides;
}

/// Times `factor`.
std::vector<float> scaled(const Weights& weights, double factor) {
    std::vector<float> result(weights.size());
    std::ranges::transform(weights, result.begin(),
                           [&](double weight) { return static_cast<float>(weight * factor); });
    return result;
}

/// Without the weights at the end that change no sum in float.
std::vector<float> cut(std::vector<float> weights) {
    while (weights.size() > 1 && weights.back() < 2e-8f) weights.pop_back();
    return weights;
}

/// The factor along one axis of a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees.
Weights sensitivity(double a, double b, double pixels_per_degree, std::size_t radius) {
    using std::numbers::pi;
    Weights weights(radius + 1);
    for (std::size_t k = 0; k <= radius; ++k) {
        const double degrees = static_cast<double>(k) / pixels_per_degree;
        weights[k] = std::sqrt(a * std::sqrt(pi / b)) * std::exp(-pi * pi * degrees * degrees / b);
    }
    return weights;
}

void set_sensitivity(FlipKernels& kernels, double pixels_per_degree) {
    // Table 1 of the paper; the widest Gaussian of all channels sets the radius of all.
    constexpr double kLuminance = 0.0047, kRedGreen = 0.0053;
    constexpr double kWide = 0.04, kWideHeight = 34.1, kNarrow = 0.025, kNarrowHeight = 13.5;
    const double deviation = std::sqrt(kWide / (2 * std::numbers::pi * std::numbers::pi));
    const auto radius = static_cast<std::size_t>(std::ceil(3 * deviation * pixels_per_degree));
    const Weights luminance = sensitivity(1, kLuminance, pixels_per_degree, radius);
    const Weights red_green = sensitivity(1, kRedGreen, pixels_per_degree, radius);
    const Weights wide = sensitivity(kWideHeight, kWide, pixels_per_degree, radius);
    const Weights narrow = sensitivity(kNarrowHeight, kNarrow, pixels_per_degree, radius);
    const double plane = std::hypot(sum(wide), sum(narrow));  // root of the sum of both over the plane
    kernels.luminance = cut(scaled(luminance, 1 / sum(luminance)));
    kernels.red_green = cut(scaled(red_green, 1 / sum(red_green)));
    kernels.blue_yellow_wide = cut(scaled(wide, 1 / plane));
    kernels.blue_yellow_narrow = cut(scaled(narrow, 1 / plane));
    kernels.radius = std::max(kernels.radius, radius);
}

void set_features(FlipKernels& kernels, double pixels_per_degree) {
    // The width of the human edge detector, 0.082 degrees, is two standard deviations.
    const double sigma = 0.5 * 0.082 * pixels_per_degree;
    const auto radius = static_cast<std::size_t>(std::ceil(3 * sigma));
    Weights gaussian(radius + 1), edge(radius + 1), point(radius + 1);
    double edge_side = 0, positive = 0, negative = 0;
    for (std::size_t k = 0; k <= radius; ++k) {
        const double x = static_cast<double>(k), sides = k == 0 ? 1 : 2;
        gaussian[k] = std::exp(-x * x / (2 * sigma * sigma));
        edge[k] = x * gaussian[k];
        point[k] = (x * x / (sigma * sigma) - 1) * gaussian[k];
        edge_side += edge[k];
        (point[k] > 0 ? positive : negative) += sides * std::abs(point[k]);
    }
    for (double& weight : point) weight /= weight > 0 ? positive : negative;
    kernels.gaussian = scaled(gaussian, 1 / sum(gaussian));
    kernels.edge = scaled(edge, 1 / edge_side);
    kernels.point = scaled(point, 1);
    kernels.radius = std::max(kernels.radius, radius);
}

}  // namespace

FlipKernels flip_kernels(double pixels_per_degree) {
    assert(pixels_per_degree >= 1);
    FlipKernels kernels;
    set_sensitivity(kernels, pixels_per_degree);
    set_features(kernels, pixels_per_degree);
    return kernels;
}

}  // namespace dapple::metrics
