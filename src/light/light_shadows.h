#pragma once
#include <cstddef>
#include <span>

#include "light/beam_mesh.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// Whether an object can stand between the light and the water at all, from bounding boxes.
bool may_shadow(const scene::FrameScene& scene, const rays::RayScene& rays, const scene::Light& light);

/// From a point on the water, m, relative to FrameScene::origin, to the light. The water is not among the
/// objects, so the ray needs no offset.
rays::Ray ray_to_light(const scene::FrameScene& scene, const scene::Light& light, glm::vec3 surface_point);

/// Sets the flux of rays to 0 whose point on the water an object hides from the light; `meshes` are those of
/// one light and one map. Returns the number of points.
std::size_t shadow_meshes(std::span<BeamMesh> meshes, const scene::FrameScene& scene,
                          const rays::RayScene& rays);

}  // namespace dapple::light
