#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// Diffuse albedo of receivers: the material's colour times its texture, filtered over the pixel's footprint.
/// Keeps the textures that it has read. Errors: Error(input_unreadable).
class AlbedoSource {
public:
    AlbedoSource();
    ~AlbedoSource();
    /// An entry a pixel; 0 where there is no receiver.
    std::vector<glm::vec3> albedo(const scene::FrameScene& scene, const view::ReceiverLayer& layer);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::render
