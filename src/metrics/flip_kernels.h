#pragma once
#include <cstddef>
#include <vector>

namespace dapple::metrics {

/// The kernels of FLIP (Andersson et al. 2020, sections 4.1.1 and 4.2), all of them separable: weights at
/// distances 0, 1, 2, ... pixels from the centre along an axis.
struct FlipKernels {
    /// Contrast sensitivity; each sums to 1 over the plane, blue-yellow as the sum of its two products. Tails
    /// below float's resolution are cut, so that lengths differ.
    std::vector<float> luminance, red_green, blue_yellow_wide, blue_yellow_narrow;
    /// Of the feature detectors: a Gaussian of sum 1, and its first and second derivative along an axis,
    /// whose positive and negative weights each sum to 1 in size. `edge` is odd, its weight at 0 is 0. The
    /// weight of `point` at 0 is what makes the whole sum to 0, and left to those who apply it as
    /// differences.
    std::vector<float> gaussian, edge, point;
    std::size_t radius = 0;  ///< the largest distance of all
};

/// At least 1 pixel a degree.
FlipKernels flip_kernels(double pixels_per_degree);

}  // namespace dapple::metrics
