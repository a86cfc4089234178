#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "media/media.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// Direction of travel of a sun's light for one of `samples` samples of its disc: equal-area points of a
/// Fibonacci spiral, the first of one being the centre.
glm::dvec3 sun_direction(const scene::Light& light, int sample, int samples);

/// What the place of a point of a square grows by from one sample to the next, whole parts dropped: any
/// number of them lie evenly (the additive sequence R2 of Roberts 2018, from the powers of the plastic
/// number).
inline constexpr glm::dvec2 kEvenStep{0.7548776662466927, 0.5698402909980532};

/// m: where the light of a lamp of the frame, `index`, comes from for one of the camera samples: of a
/// part of an area light a point of its own for each, of which those of all parts lie evenly too.
glm::dvec3 lamp_position(const scene::FrameState& state, std::size_t index, int sample);

/// Whether a lamp is under water, by the rest plane.
bool light_in_water(const scene::FrameState& state, const scene::Light& light);

/// E_direct [W/m^2], an entry a pixel: light that reaches the receivers without a specular event, from lights
/// on the same side of the water, shadowed by objects and dimmed by media. A sun with a disc is sampled in
/// one direction a layer, and each part of an area light in one point, from sets fixed by the layer's sample,
/// equal for all pixels and frames.
std::vector<glm::vec3> direct_irradiance(const scene::FrameScene& scene, const media::Media& media,
                                         const rays::RayScene& rays, const view::ReceiverLayer& layer);

/// Stand-in for E [W/m^2] at receivers in the water that the method does not cover (`covered` 0), or whose
/// light would enter an open water outside its extent, where no light is cast: what flat water would let
/// through, shadowed by objects and dimmed by media on both sides of the surface. 0 elsewhere.
std::vector<glm::vec3> flat_water_irradiance(const scene::FrameScene& scene, const media::Media& media,
                                             const rays::RayScene& rays, const view::ReceiverLayer& layer,
                                             const std::vector<std::uint8_t>& covered);

/// E_sky [W/m^2] (CONVENTIONS.md, "Light").
std::vector<glm::vec3> sky_irradiance(const scene::FrameScene& scene, const view::ReceiverLayer& layer);

}  // namespace dapple::render
