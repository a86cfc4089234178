#include "methods/photon_splatting/receiver_code.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods {

std::uint32_t receiver_code(glm::vec3 n, bool in_water) {
    constexpr float kSteps = 8191;
    const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    glm::vec2 f = glm::vec2(n.x, n.z) / sum;
    if (n.y < 0) f = glm::vec2(std::copysign(1 - std::abs(f.y), f.x), std::copysign(1 - std::abs(f.x), f.y));
    const auto quantized = [](float x) {
        return static_cast<std::uint32_t>(std::lround(std::clamp(x, -1.0f, 1.0f) * kSteps) + 8191);
    };
    return (in_water ? 0x80000000u : 0u) | 0x20000000u | quantized(f.x) << 14 | quantized(f.y);
}

}  // namespace dapple::methods
