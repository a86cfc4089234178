#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>

namespace dapple::denoise {

/// Luminance by the weights of Rec.709, as OCIO's configs state them for scene_linear.
float luminance(const glm::vec3& color);

/// How far a pixel's filter reaches (Kougianos and Moustakas 2021, section 3.3).
struct Kernel {
    int radius;            ///< rho, pixels
    int step;              ///< lambda, pixels
    float distance_scale;  ///< delta: cm in the paper, whose unit of length that is
};

/// Equations 26 to 28, from the darkest pixels to the brightest. The filter of fixed radius is the last one.
inline constexpr std::array<Kernel, 3> kAdaptiveKernels{{{15, 5, 15}, {10, 1, 2}, {5, 1, 1}}};
inline constexpr float kFixedDistanceScale = 1;

/// Which of them a pixel has. `scene_luminance` is C_scene of equation 25: a threshold (0.114 there, 0.144 in
/// algorithm 4) times the luminance of the weakest light.
std::size_t adaptive_level(float luminance, float scene_luminance);

}  // namespace dapple::denoise
