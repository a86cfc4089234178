#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "base/large_vector.h"
#include "light/beam_mesh.h"
#include "rays/ray_scene.h"

namespace dapple::light {

/// Where the rays of a beam mesh first meet an object, a vertex each.
struct Landings {
    LargeVector<float> depth;       ///< m along the mesh's axis; infinite: not lit, or nothing hit
    LargeVector<glm::vec3> normal;  ///< unit, geometric, against the ray
    std::size_t count = 0;          ///< rays that landed, of those that carry light
};

/// Traces the rays that are lit, from the surface on. They start on the water, which is not among the
/// objects, so they need no offset: an object that pierces the surface is met from its first point under
/// (over) the water.
Landings land(const BeamMesh& mesh, const rays::RayScene& rays);
/// The same, in the memory of others.
void land(const BeamMesh& mesh, const rays::RayScene& rays, Landings& landings);

}  // namespace dapple::light
