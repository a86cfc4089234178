#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "render/texture_files.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// Diffuse albedo of receivers, an entry a pixel: the material's colour times its texture, filtered over the
/// pixel's footprint; 0 where there is no receiver. Errors: Error(input_unreadable).
std::vector<glm::vec3> find_albedo(const scene::FrameScene& scene, const view::ReceiverLayer& layer,
                                   TextureFiles& files);

}  // namespace dapple::render
