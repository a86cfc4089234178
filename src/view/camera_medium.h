#pragma once
#include <glm/glm.hpp>

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

/// m: what floats can tell from the surface, with room. `position` is relative to FrameScene::origin.
inline double surface_margin(const glm::dvec3& position) {
    const glm::dvec3 size = glm::abs(position);
    return 0x1p-20 * (1 + glm::max(size.x, glm::max(size.y, size.z)));
}

}  // namespace dapple::view
