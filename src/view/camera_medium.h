#pragma once
#include <glm/glm.hpp>

#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::view {

/// Where a camera path starts.
struct CameraMedium {
    bool in_water = false;
    /// Nearer to the water's surface than surface_margin(): taken to be under it.
    bool at_surface = false;
};

/// Of a camera whose paths start in one point: the rules of camera_in_water().
CameraMedium camera_medium(const scene::FrameScene& scene);

/// Whether what lies about a point is water, were no object there: the nearest water above it shows it its
/// lower side; where the mesh does not cover it, below the rest plane of open water. Relative to
/// FrameScene::origin; points nearer to the surface than floats can tell may be on either side.
bool point_in_water(const scene::FrameScene& scene, const rays::RayScene& rays, const glm::dvec3& point);

/// m: what floats can tell from the surface, with room. `position` is relative to FrameScene::origin.
inline double surface_margin(const glm::dvec3& position) {
    const glm::dvec3 size = glm::abs(position);
    return 0x1p-20 * (1 + glm::max(size.x, glm::max(size.y, size.z)));
}

}  // namespace dapple::view
