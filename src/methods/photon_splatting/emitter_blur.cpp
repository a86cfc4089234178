#include "methods/photon_splatting/emitter_blur.h"

#include "optics/optics.h"

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

glm::mat2 EmitterBlur::covariance(const PhotonHit& hit, glm::vec3 right, glm::vec3 up) const {
    const std::size_t i = hit.photon;
    const glm::vec3 way = grid_.surface_point(i) - grid_.light_position();
    const glm::vec3 incident = grid_.incident(i), normal = grid_.normal(i);
    const bool reflection = grid_.mesh().event == light::Event::reflection;
    glm::mat2 sum(0);
    for (const glm::vec3& spread : {spread_u_, spread_v_}) {
        const glm::vec3 turned = optics::f32::normalized_differential(way, -spread);
        const glm::vec3 leaving =
            reflection
                ? optics::f32::reflected_differential(incident, normal, turned, glm::vec3(0))
                : optics::f32::refracted_differential(incident, normal, grid_.eta(), turned, glm::vec3(0));
        const glm::vec3 moved =
            optics::f32::transferred_differential(glm::vec3(0), leaving, hit.beam, hit.way, hit.normal);
        const glm::vec2 on_plane(glm::dot(moved, right), glm::dot(moved, up));
        sum += glm::outerProduct(on_plane, on_plane);
    }
    const float trace = sum[0][0] + sum[1][1];
    return sum + glm::mat2(kLeastRatio * trace + kLeastSpread * hit.way * hit.way);
}

}  // namespace dapple::methods
