#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "image/texture.h"
#include "scene/frame_state.h"

namespace dapple::render {

/// Reads textures and keeps them.
class TextureFiles {
public:
    /// Null where `path` is empty. Error(input_unreadable).
    std::shared_ptr<const image::Texture> get(const std::string& path, const scene::Output& output);
    /// What a light throws: negative texels are Error(input_unreadable) too.
    std::shared_ptr<const image::Texture> of_light(const scene::Light& light, const scene::Output& output);

private:
    /// By path and OCIO config, which decides how code values become linear.
    std::map<std::pair<std::string, std::string>, std::shared_ptr<const image::Texture>> textures_;
};

/// Reads the textures of lights, so that what is wrong with them is known before anything is rendered.
/// Error(input_unreadable).
void check_light_textures(const scene::FrameState& state);

}  // namespace dapple::render
