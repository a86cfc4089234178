#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace dapple::methods::adaptive_beams {

/// Blurs a picture by a Gaussian of that standard deviation [pixels], each pixel's value by the weighted mean
/// over the pixels that are `covered`, within four standard deviations; others keep theirs. So are the sharp
/// edges of the paper's surface term removed (Liktor and Dachsbacher 2011, section 5), and with them what is
/// as fine.
void low_pass(std::span<glm::vec3> picture, std::span<const std::uint8_t> covered, int width,
              double deviation);

}  // namespace dapple::methods::adaptive_beams
