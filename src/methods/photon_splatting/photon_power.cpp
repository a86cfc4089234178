#include "methods/photon_splatting/photon_power.h"

#include <algorithm>
#include <cmath>

#include "optics/optics.h"

namespace dapple::methods {
namespace {

// Kougianos and Moustakas 2021. Equation 13: gamma as given; t_Max is not given: the largest
// range of light of section 4 is taken (6000 Unreal units of 1 cm). Equation 14: its exponent is not given,
// and is Schlick's; nor is F_frac, which is the reflectance at normal incidence.
constexpr float kFocusBias = 0.95f;
constexpr float kFarthestRay = 60;  // m
constexpr float kFresnelExponent = 5;

/// Equation 13: from 0 at the water up to 1 at (1 - gamma) t_Max, and down to 0 at t_Max.
float paper_attenuation(float way) {
    const float near = 1 - way / kFarthestRay;
    return near > kFocusBias ? 1 - (near - kFocusBias) / (1 - kFocusBias)
                             : std::max(0.0f, 1 - (kFocusBias - near) / kFocusBias);
}

}  // namespace

PhotonPower::PhotonPower(const scene::FrameScene& scene, const media::Media& media, const PhotonGrid& grid,
                         bool paper)
    : grid_(grid), ways_(scene, media, grid.mesh()), paper_(paper) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(grid.mesh().light)];
    color_ = glm::vec3(grid.sun() ? light.irradiance : light.intensity);
}

glm::vec3 PhotonPower::at(const PhotonHit& hit) const {
    const light::BeamMesh& mesh = grid_.mesh();
    glm::vec3 power = mesh.flux[hit.photon] * color_;
    if (!mesh.tint.empty()) power *= mesh.tint[hit.photon];
    return power * (paper_ ? glm::vec3(paper_share(hit))
                           : ways_.of(grid_.surface_point(hit.photon), hit.point, hit.way));
}

/// The paper's F and I_att over Fresnel's exact share, which is in the flux.
float PhotonPower::paper_share(const PhotonHit& hit) const {
    const std::size_t i = hit.photon;
    const float eta = grid_.eta();
    const float cos_i = glm::clamp(-glm::dot(grid_.incident(i), grid_.normal(i)), 0.0f, 1.0f);
    const float cos_t = optics::f32::transmitted_cosine(cos_i, eta);
    const float straight_on = optics::f32::fresnel_reflectance(1.0f, 1.0f, eta);
    const float reflected = straight_on + (1 - straight_on) * std::pow(1 - cos_i, kFresnelExponent);
    const bool reflection = grid_.mesh().event == light::Event::reflection;
    const float exact = reflection ? optics::f32::fresnel_reflectance(cos_i, cos_t, eta)
                                   : optics::f32::fresnel_transmittance(cos_i, cos_t, eta);
    const float share = reflection ? reflected : 1 - reflected;
    return exact > 0 ? share / exact * paper_attenuation(hit.way) : 0.0f;
}

}  // namespace dapple::methods
