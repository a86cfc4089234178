#include "denoise/adaptive_kernel.h"

namespace dapple::denoise {

float luminance(const glm::vec3& color) {
    return glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

AdaptiveKernel adaptive_kernel(float luminance, float scene_luminance) {
    if (luminance < 0.1f * scene_luminance) return {kLargestAdaptiveRadius, 5, 15};
    if (luminance < 0.5f * scene_luminance) return {10, 1, 2};
    return {5, 1, 1};
}

}  // namespace dapple::denoise
