#include "methods/photon_splatting/kernel.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods {
namespace {

constexpr float kSmallestSpacing = 0.01f;  // pixels
constexpr float kSmallestBox = 0.002f;     // of the support

/// Length in pixels along the nearer axis of the picture: a box of extent 1 sums to the same over rows (or
/// columns) of pixels wherever it lies, also when it runs obliquely.
float extent(glm::vec2 vector) {
    return std::max(std::abs(vector.x), std::abs(vector.y));
}

/// Makes the half-extents of the kernel of a vector of the lattice, times the style's scale, and its box.
void widen(glm::vec2& vector, float& box, float pixels, const KernelMetric& metric,
           const KernelStyle& style) {
    const bool tent = style.shape == KernelShape::tent;
    // Both in units of the vector: half-widths of the shape and of the box that it is convolved with.
    float core = tent ? 1.0f : 0.5f, half = 0;
    if (style.widened) {
        const float across = std::sqrt(std::max(1e-30f, glm::dot(vector, metric.beam_gram * vector)));
        const float radius = metric.disc_radius / across;
        // Variances along a line: of a box of width w w^2 / 12, of a tent of half-width c c^2 / 6, of a disc
        // of radius R R^2 / 4.
        if (style.scale == std::round(style.scale)) {
            const float pixel = (tent ? std::clamp(2 - pixels, 0.0f, 1.0f) : 1.0f) / pixels;
            half = 0.5f * std::sqrt(pixel * pixel + 3 * radius * radius);
        } else {  // only the pixel's own box makes the samples of pixels hold the flux
            core = std::sqrt(core * core + (tent ? 1.5f : 0.75f) * radius * radius);
            half = 0.5f / pixels;
        }
    }
    // A box's edge of no width has no profile; of a tent such a box would change less than round-off.
    if (half < kSmallestBox * (core + half)) half = tent ? 0.0f : core * kSmallestBox / (1 - kSmallestBox);
    box = half / (core + half);
    vector *= core + half;
}

}  // namespace

glm::mat2 reduction_metric(const KernelMetric& metric) {
    const glm::mat2 pixel = glm::transpose(metric.pixel_from_plane) * metric.pixel_from_plane;
    if (metric.disc_radius == 0) return pixel;
    // Covariances add: a pixel's box 1/12, the disc's R^2 / 4.
    const float disc = 3 * metric.disc_radius * metric.disc_radius;
    return glm::inverse(glm::inverse(pixel) + disc * glm::inverse(metric.beam_gram));
}

PlaneKernel widened_kernel(const LatticeBasis& basis, const KernelMetric& metric, const KernelStyle& style) {
    PlaneKernel kernel{style.scale * basis.first, style.scale * basis.second, 0, 0};
    glm::vec2 first = metric.pixel_from_plane * kernel.first,
              second = metric.pixel_from_plane * kernel.second;
    if (style.widened) {
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
    }
    widen(kernel.first, kernel.box_first, extent(first), metric, style);
    widen(kernel.second, kernel.box_second, extent(second), metric, style);
    return kernel;
}

}  // namespace dapple::methods
