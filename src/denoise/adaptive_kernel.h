#pragma once
#include <glm/glm.hpp>

namespace dapple::denoise {

/// Luminance by the weights of Rec.709, as OCIO's configs state them for scene_linear.
float luminance(const glm::vec3& color);

/// How far a pixel's filter reaches (Kougianos and Moustakas 2021, section 3.3).
struct AdaptiveKernel {
    int radius;            ///< rho, pixels
    int step;              ///< lambda, pixels
    float distance_scale;  ///< delta, cm: lengths are Unreal's units there
};

inline constexpr int kLargestAdaptiveRadius = 15;

/// Equations 26 to 28. `scene_luminance` is C_scene of equation 25: a threshold (0.114 there, 0.144 in
/// algorithm 4) times the luminance of the weakest light.
AdaptiveKernel adaptive_kernel(float luminance, float scene_luminance);

}  // namespace dapple::denoise
