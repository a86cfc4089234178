#include "methods/photon_splatting/emitter_blur.h"

#include <cmath>

#include "scene/area_light.h"

namespace dapple::methods {
namespace {

// Of the larger variance, at least, that the smaller one is; and of the square of the way, that both are.
constexpr float kLeastRatio = 1e-4f, kLeastSpread = 1e-10f;

}  // namespace

EmitterBlur::EmitterBlur(const scene::FrameScene& scene, const PhotonGrid& grid) : grid_(grid) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(grid.mesh().light)];
    any_ = light.part.count > 0 || (grid.sun() && grid.mesh().mirrored() && light.angular_diameter > 0);
    spread_u_ = glm::vec3(light.part.spread_u);
    spread_v_ = glm::vec3(light.part.spread_v);
    if (!grid.sun()) return;
    // A disc's variance along a line is a quarter of its radius squared.
    const scene::LightFrame across = scene::light_frame(light);
    const double deviation = 0.5 * std::tan(0.5 * light.angular_diameter);
    spread_u_ = glm::vec3(deviation * across.right);
    spread_v_ = glm::vec3(deviation * across.up);
}

Metric EmitterBlur::inverse_covariance(const Photons& photons, const PhotonHits& hits, Vectors3 right,
                                       Vectors3 up) const {
    Metric sum{{}, {}, {}};
    for (const glm::vec3& spread : {spread_u_, spread_v_}) {
        const Vectors3 turned = grid_.sun() ? all(spread) : grid_.turned(photons, all(-spread), photons.on);
        PhotonGrid::Leaving leaving;
        leaving.direction = grid_.spread(photons, turned, {}, photons.on);
        if (grid_.mesh().mirrored())
            leaving.mirror_turn =
                grid_.mirror_turn(photons, grid_.moved_on_mirror(photons, {}, leaving.direction, photons.on));
        const Vectors3 moved = grid_.carried(photons, hits, leaving, photons.on);
        const Floats x = dot(moved, right), y = dot(moved, up);
        sum.xx += x * x;
        sum.xy += x * y;
        sum.yy += y * y;
    }
    const Floats least = kLeastRatio * (sum.xx + sum.yy) + kLeastSpread * hits.way * hits.way;
    sum.xx += least;
    sum.yy += least;
    const Floats scale = 1.0f / (sum.xx * sum.yy - sum.xy * sum.xy);
    return {scale * sum.yy, -scale * sum.xy, scale * sum.xx};
}

}  // namespace dapple::methods
