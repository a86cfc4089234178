#include "methods/photon_splatting/emitter_blur.h"

namespace dapple::methods {
namespace {

// Of the larger variance, at least, that the smaller one is; and of the square of the way, that both are.
constexpr float kLeastRatio = 1e-4f, kLeastSpread = 1e-10f;

}  // namespace

EmitterBlur::EmitterBlur(const scene::FrameScene& scene, const PhotonGrid& grid) : grid_(grid) {
    const scene::EmitterPart& part = scene.state.lights[static_cast<std::size_t>(grid.mesh().light)].part;
    any_ = part.count > 0;
    spread_u_ = glm::vec3(part.spread_u);
    spread_v_ = glm::vec3(part.spread_v);
}

Metric EmitterBlur::inverse_covariance(const Photons& photons, const PhotonHits& hits, Vectors3 right,
                                       Vectors3 up) const {
    Metric sum{{}, {}, {}};
    for (const glm::vec3& spread : {spread_u_, spread_v_}) {
        const Vectors3 turned = grid_.turned(photons, all(-spread), photons.on);
        const Vectors3 leaving = grid_.spread(photons, turned, {}, photons.on);
        const Vectors3 moved = grid_.carried(photons, hits, {{}, leaving, {}}, photons.on);
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
