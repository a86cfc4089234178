#include "denoise/adaptive_kernel.h"

namespace dapple::denoise {

float luminance(const glm::vec3& color) {
    return glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

std::size_t adaptive_level(float luminance, float scene_luminance) {
    if (luminance < 0.1f * scene_luminance) return 0;
    return luminance < 0.5f * scene_luminance ? 1 : 2;
}

}  // namespace dapple::denoise
