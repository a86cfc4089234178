#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "view/receiver_layer.h"

namespace dapple::denoise {

inline constexpr std::uint32_t kNoSurface = 0;

/// What filters know of the receiver of a pixel, so that light does not leak over edges.
struct Guide {
    glm::vec3 position{0};               ///< m
    glm::vec3 normal{0, 1, 0};           ///< unit, shading
    std::uint32_t surface = kNoSurface;  ///< object, medium, whether it is seen by a specular surface
    float narrow = 0;                    ///< m, the shorter side of the pixel's footprint
    float wide = 0;                      ///< m, the longer one
    float rounding = 0;                  ///< m, of the position
};

/// Of a pixel; kNoSurface where it has no receiver.
Guide guide_of(const view::ReceiverLayer& layer, std::size_t pixel);

/// How much two receivers that are some pixels apart belong to one surface: 1 on a plane, exactly 0 across
/// edges. Symmetric. 0 beyond any of: another object or medium; normals more than 26 deg apart; out of
/// either's tangent plane by a tenth of a pixel a pixel (of the footprints' shorter sides); four times as far
/// apart as their footprints say.
float edge_stop(const Guide& a, const Guide& b, float pixels_apart);

}  // namespace dapple::denoise
