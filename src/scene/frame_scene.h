#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "scene/frame_state.h"
#include "scene/mesh.h"

namespace dapple::grids {
class DensityGrid;
}
namespace dapple::image {
class Texture;
}

namespace dapple::scene {

/// What a frame is rendered from: the state of the timeline and the geometry that render/ built for it.
struct FrameScene {
    FrameState state;
    std::shared_ptr<const WaterMesh> water;  ///< null where there is no water
    /// Triangles of the objects whose shape is a mesh, as read from the file (object space); null for others.
    std::vector<std::shared_ptr<const TriangleMesh>> object_meshes;
    /// Densities of the media that are grids; null for others, and where a missing file leaves nothing.
    std::vector<std::shared_ptr<const grids::DensityGrid>> medium_grids;
    /// What spots throw; null for lights without a texture. May be shorter than FrameState::lights.
    std::vector<std::shared_ptr<const image::Texture>> light_textures;
    /// m; float positions of the frame are relative to this point, which is snapped to whole metres.
    glm::dvec3 origin{0, 0, 0};
};

}  // namespace dapple::scene
