#include "methods/photon_splatting/kernel.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods {
namespace {

constexpr float kSmallestSpacing = 0.01f;  // pixels
constexpr float kSmallestBox = 0.002f;     // of the support; below, the box changes less than round-off does

/// Length in pixels along the nearer axis of the picture: a box of extent 1 sums to the same over rows (or
/// columns) of pixels wherever it lies, also when it runs obliquely.
float extent(glm::vec2 vector) {
    return std::max(std::abs(vector.x), std::abs(vector.y));
}

/// Half-width of the box in units of the lattice vector.
float half_box(glm::vec2 vector, float pixels, const KernelMetric& metric) {
    const float pixel = std::clamp(2 - pixels, 0.0f, 1.0f) / pixels;
    // Variance of a box of width w: w^2 / 12; of a disc of radius R along a line: R^2 / 4.
    const float across = std::sqrt(std::max(1e-30f, glm::dot(vector, metric.beam_gram * vector)));
    const float disc = std::sqrt(3.0f) * metric.disc_radius / across;
    return 0.5f * std::sqrt(pixel * pixel + disc * disc);
}

void widen(glm::vec2& vector, float& box, float pixels, const KernelMetric& metric) {
    const float half = half_box(vector, pixels, metric);
    box = half / (1 + half);
    if (box < kSmallestBox) {
        box = 0;
    } else {
        vector *= 1 + half;
    }
}

}  // namespace

glm::mat2 reduction_metric(const KernelMetric& metric) {
    const glm::mat2 pixel = glm::transpose(metric.pixel_from_plane) * metric.pixel_from_plane;
    if (metric.disc_radius == 0) return pixel;
    // Covariances add: a pixel's box 1/12, the disc's R^2 / 4.
    const float disc = 3 * metric.disc_radius * metric.disc_radius;
    return glm::inverse(glm::inverse(pixel) + disc * glm::inverse(metric.beam_gram));
}

PlaneKernel widened_kernel(const LatticeBasis& basis, const KernelMetric& metric) {
    PlaneKernel kernel{basis.first, basis.second, 0, 0};
    glm::vec2 first = metric.pixel_from_plane * kernel.first,
              second = metric.pixel_from_plane * kernel.second;
    if (glm::length(second) < kSmallestSpacing) {
        second = {0, kSmallestSpacing};
        kernel.second = glm::inverse(metric.pixel_from_plane) * second;
    }
    const float second_length = glm::length(second);
    const float area = std::abs(first.x * second.y - first.y * second.x);
    if (!(area > kSmallestSpacing * second_length * 0.01f) || glm::length(first) < kSmallestSpacing) {
        first = glm::vec2(-second.y, second.x) * (kSmallestSpacing / second_length);
        kernel.first = glm::inverse(metric.pixel_from_plane) * first;
    }
    widen(kernel.first, kernel.box_first, extent(first), metric);
    widen(kernel.second, kernel.box_second, extent(second), metric);
    return kernel;
}

}  // namespace dapple::methods
