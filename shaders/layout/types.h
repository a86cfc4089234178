// What lets the structs of this folder be GLSL and C++: float only, scalar block layout on the device, a unit
// and a space on every field. C++ sees them in dapple::layout; sizes are asserted where the host fills them.
#ifndef DAPPLE_LAYOUT_TYPES
#define DAPPLE_LAYOUT_TYPES
#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
namespace dapple::layout {
using glm::ivec3;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = std::uint32_t;
}  // namespace dapple::layout
#define LAYOUT_BEGIN namespace dapple::layout {
#define LAYOUT_END }
#else
#define LAYOUT_BEGIN
#define LAYOUT_END
#endif
#endif
