#pragma once
#include <glm/glm.hpp>
#include <optional>

#include "scene/frame_state.h"

namespace dapple::render {

/// Light of one source at a point below flat water (the plane y = 0), the source being above it.
struct FlatWaterLight {
    glm::dvec3 direction;    ///< unit, of travel in the water
    glm::dvec3 entry;        ///< m, world: where the light enters the water
    glm::dvec3 from;         ///< unit, of travel in the air, towards `entry`
    double source_distance;  ///< m from the light to `entry`; infinite for a sun
    /// Irradiance on a plane that faces `direction`, of a light of unit irradiance or intensity, after
    /// Fresnel and before extinction: [1] for a sun, [1/m^2] else.
    double transport;
    double water_distance;  ///< m from `entry` to the receiver
};

/// Closed form (flat interface: a sun by Snell; a point light by the one root of a tan i + b tan t = r, and
/// E = I T sin i / (r dr/di), flux conservation between neighbouring cones). Empty where the receiver is not
/// below the plane, the light is not above it, or the receiver lies outside the cone of a spot light.
std::optional<FlatWaterLight> through_flat_water(const scene::Light& light, glm::dvec3 receiver,
                                                 double refractive_index);

/// Share of a spot light's intensity in a direction: 1 inside the cone less its edge, 0 outside, smooth
/// between; of an area light's the cosine to its normal, 0 behind it; 1 for other lights. A spot's picture
/// (light::SpotPicture) is neither here nor in `transport`.
double spot_falloff(const scene::Light& light, glm::dvec3 direction);

}  // namespace dapple::render
