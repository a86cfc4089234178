#pragma once
#include <cstdint>
#include <glm/glm.hpp>

namespace dapple::methods {

/// A receiver's normal and medium in one word that is a normal float whatever they are, as it travels in the
/// fourth channel of a float image: bit 31 the medium (1: water), bits 29 to 30 fixed, bits 14 to 27 and 0 to
/// 13 the octahedral coordinates about the y axis. Axes of the world are exact, others within 2e-4. Read by
/// splat_fragment.glsl.
std::uint32_t receiver_code(glm::vec3 unit_normal, bool in_water);

}  // namespace dapple::methods
