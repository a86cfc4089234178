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

Vectors3 PhotonPower::at(const Photons& photons, const PhotonHits& hits) const {
    const light::BeamMesh& mesh = grid_.mesh();
    Floats flux;
    for (std::size_t k = 0; k < kPhotons; ++k) flux[k] = mesh.flux[photons.vertex[k]];
    Vectors3 power = flux * share(photons, hits);
    power = {color_.x * power.x, color_.y * power.y, color_.z * power.z};
    if (mesh.tint.empty()) return power;
    for (std::size_t k = 0; k < kPhotons; ++k)
        set_lane(power, k, lane(power, k) * mesh.tint[photons.vertex[k]]);
    return power;
}

/// What is left of the light on its way.
Vectors3 PhotonPower::share(const Photons& photons, const PhotonHits& hits) const {
    if (paper_) {
        const Floats share = paper_share(photons, hits);
        return {share, share, share};
    }
    const light::BeamMesh& mesh = grid_.mesh();
    if (ways_.only_water()) {
        Floats in_water = mesh.in_water() ? hits.way : Floats{};
        if (mesh.from_below && !mesh.mirrored()) {
            const Vectors3 before = photons.own.surface - all(grid_.light_position());
            in_water += lanes::square_root<float>(dot(before, before));
        }
        // A plane that a photon is splatted on may lie above where it leaves the water, by round-off.
        in_water = lanes::greater(in_water, Floats{});
        const glm::vec3 extinction = ways_.extinction();
        return {lanes::decay(extinction.x * in_water), lanes::decay(extinction.y * in_water),
                lanes::decay(extinction.z * in_water)};
    }
    Vectors3 share;
    for (std::size_t k = 0; k < kPhotons; ++k)
        if (photons.on[k] != 0)
            set_lane(share, k, ways_.of(lane(photons.own.surface, k), lane(hits.point, k), hits.way[k]));
    return share;
}

/// The paper's F and I_att over Fresnel's exact share, which is in the flux.
Floats PhotonPower::paper_share(const Photons& photons, const PhotonHits& hits) const {
    const float eta = grid_.eta();
    const Floats cosines = -dot(grid_.incident(photons.own), grid_.normal(photons.own));
    const float straight_on = optics::f32::fresnel_reflectance(1.0f, 1.0f, eta);
    const bool reflection = grid_.mesh().event == light::Event::reflection;
    Floats result{};
    for (std::size_t k = 0; k < kPhotons; ++k) {
        const float cos_i = glm::clamp(static_cast<float>(cosines[k]), 0.0f, 1.0f);
        const float cos_t = optics::f32::transmitted_cosine(cos_i, eta);
        const float reflected = straight_on + (1 - straight_on) * std::pow(1 - cos_i, kFresnelExponent);
        const float exact = reflection ? optics::f32::fresnel_reflectance(cos_i, cos_t, eta)
                                       : optics::f32::fresnel_transmittance(cos_i, cos_t, eta);
        const float share = reflection ? reflected : 1 - reflected;
        if (exact > 0) result[k] = share / exact * paper_attenuation(hits.way[k]);
    }
    return result;
}

}  // namespace dapple::methods
