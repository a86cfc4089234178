#pragma once
#include <cmath>
#include <glm/glm.hpp>

/// The physics that shaders and C++ share (shaders/optics/), in float (`dapple::optics::f32`, what the device
/// runs) and in double (`dapple::optics::f64`).
namespace dapple::optics {

#include "optics/language.h"

namespace f32 {
using real = float;
using real2 = glm::vec2;
using real3 = glm::vec3;
using glm::cross;
using glm::dot;
using glm::length;
using glm::max;
using glm::min;
using glm::normalize;
using glm::pow;
using glm::sqrt;
using std::fma;
// Each uses what stands before it.
// clang-format off
#include "optics/refraction.h"
#include "optics/ray_differential.h"
#include "optics/spot_light.h"
#include "optics/phase.h"
// clang-format on
}  // namespace f32

namespace f64 {
using real = double;
using real2 = glm::dvec2;
using real3 = glm::dvec3;
using glm::cross;
using glm::dot;
using glm::length;
using glm::max;
using glm::min;
using glm::normalize;
using glm::pow;
using glm::sqrt;
using std::fma;
// Each uses what stands before it.
// clang-format off
#include "optics/refraction.h"
#include "optics/ray_differential.h"
#include "optics/spot_light.h"
#include "optics/phase.h"
// clang-format on
}  // namespace f64

}  // namespace dapple::optics
