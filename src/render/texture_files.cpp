#include "render/texture_files.h"

#include <algorithm>

#include "base/error.h"
#include "color/grader.h"

namespace dapple::render {

std::shared_ptr<const image::Texture> TextureFiles::get(const std::string& path,
                                                        const scene::Output& output) {
    if (path.empty()) return nullptr;
    std::shared_ptr<const image::Texture>& known = textures_[{path, output.ocio_config}];
    if (!known) {
        const color::Grader grader({output.ocio_config, output.display, output.view, output.look});
        known = std::make_shared<const image::Texture>(
            image::Texture::load(path, [&](std::span<float> rgb) { grader.texture_to_linear(rgb); }));
    }
    return known;
}

std::shared_ptr<const image::Texture> TextureFiles::of_light(const scene::Light& light,
                                                             const scene::Output& output) {
    std::shared_ptr<const image::Texture> texture = get(light.texture, output);
    if (!texture) return nullptr;
    const std::span<const float> rgb = texture->rgb();
    const auto found = std::ranges::find_if(rgb, [](float value) { return value < 0; });
    if (found != rgb.end()) {
        const auto pixel = static_cast<std::size_t>(found - rgb.begin()) / 3;
        const auto width = static_cast<std::size_t>(texture->width());
        throw Error(ExitCode::input_unreadable,
                    light.texture + ": light is not negative, which the texture is in " +
                        std::to_string(std::ranges::count_if(rgb, [](float value) { return value < 0; })) +
                        " values, first at pixel " + std::to_string(pixel % width) + "," +
                        std::to_string(pixel / width));
    }
    return texture;
}

void check_light_textures(const scene::FrameState& state) {
    TextureFiles files;
    for (const scene::Light& light : state.lights) files.of_light(light, state.output);
}

}  // namespace dapple::render
