#include "denoise/guide.h"

#include <algorithm>
#include <cmath>

namespace dapple::denoise {
namespace {

constexpr float kLeastCosine = 0.9f;  ///< of normals
constexpr float kMostSlope = 0.1f;    ///< out of the plane, in shorter sides of footprints a pixel
constexpr float kMostStretch = 4;     ///< of the distance, in longer sides of footprints a pixel
/// Of the distance from the origin: rounding of positions.
constexpr float kRounding = 1e-6f;

}  // namespace

Guide guide_of(const view::ReceiverLayer& layer, std::size_t pixel) {
    const std::uint32_t flags = layer.flags[pixel];
    Guide guide;
    if (!(flags & view::kReceiver)) return guide;
    guide.position = layer.position[pixel];
    guide.normal = layer.shading_normal[pixel];
    guide.surface = 1 + 8 * layer.object[pixel] + (flags & view::kInWater ? 1u : 0u) +
                    (flags & view::kInGlass ? 2u : 0u) + (flags & view::kBehindSpecular ? 4u : 0u);
    const float u = glm::length(layer.footprint_u[pixel]), v = glm::length(layer.footprint_v[pixel]);
    guide.rounding =
        kRounding * (std::abs(guide.position.x) + std::abs(guide.position.y) + std::abs(guide.position.z));
    guide.narrow = std::min(u, v);
    guide.wide = std::max(u, v);
    return guide;
}

float edge_stop(const Guide& a, const Guide& b, float pixels_apart) {
    if (a.surface != b.surface || a.surface == kNoSurface) return 0;
    const float cosine = glm::dot(a.normal, b.normal);
    if (!(cosine > kLeastCosine)) return 0;
    const glm::vec3 step = b.position - a.position;
    const float rounding = a.rounding + b.rounding;
    const float off = std::max(std::abs(glm::dot(a.normal, step)), std::abs(glm::dot(b.normal, step)));
    const float slope = std::max(0.0f, off - rounding) /
                        (kMostSlope * pixels_apart * 0.5f * (a.narrow + b.narrow) + rounding);
    if (!(slope < 1)) return 0;
    const float reach = kMostStretch * pixels_apart * 0.5f * (a.wide + b.wide) + rounding;
    if (!(glm::dot(step, step) < reach * reach)) return 0;
    return (1 - slope * slope) * std::min(1.0f, (cosine - kLeastCosine) / (1 - kLeastCosine));
}

}  // namespace dapple::denoise
