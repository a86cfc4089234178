#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "light/beam_mesh.h"
#include "rays/ray_scene.h"

namespace dapple::light {

/// Where the rays of a beam mesh first meet an object, a vertex each.
struct Landings {
    std::vector<float> depth;       ///< m along the mesh's axis; infinite: no light, or nothing hit
    std::vector<glm::vec3> normal;  ///< unit, geometric, against the ray
    std::size_t count = 0;          ///< rays that landed
};

/// Traces the rays that carry light, from the surface on. They start on the water, which is not among the
/// objects, so they need no offset: an object that pierces the surface is met from its first point under
/// (over) the water.
Landings land(const BeamMesh& mesh, const rays::RayScene& rays);

}  // namespace dapple::light
