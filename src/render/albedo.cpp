#include "render/albedo.h"

#include <map>

#include "base/parallel.h"
#include "color/grader.h"
#include "image/texture.h"

namespace dapple::render {

struct AlbedoSource::State {
    /// By path and OCIO config, which decides how code values become linear.
    std::map<std::pair<std::string, std::string>, std::unique_ptr<const image::Texture>> textures;

    const image::Texture* texture(const std::string& path, const scene::Output& output) {
        if (path.empty()) return nullptr;
        std::unique_ptr<const image::Texture>& known = textures[{path, output.ocio_config}];
        if (!known) {
            const color::Grader grader({output.ocio_config, output.display, output.view, output.look});
            known = std::make_unique<const image::Texture>(
                image::Texture::load(path, [&](std::span<float> rgb) { grader.texture_to_linear(rgb); }));
        }
        return known.get();
    }
};

AlbedoSource::AlbedoSource() : state_(std::make_unique<State>()) {}
AlbedoSource::~AlbedoSource() = default;

std::vector<glm::vec3> AlbedoSource::albedo(const scene::FrameScene& scene,
                                            const view::ReceiverLayer& layer) {
    std::vector<const image::Texture*> textures;
    for (const scene::Object& object : scene.state.objects) {
        textures.push_back(state_->texture(object.material.texture, scene.state.output));
    }
    std::vector<glm::vec3> albedo(layer.pixels(), glm::vec3(0));
    parallel_for(layer.pixels(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!(layer.flags[i] & view::kReceiver)) continue;
            const std::uint32_t object = layer.object[i];
            albedo[i] = glm::vec3(scene.state.objects[object].material.color);
            if (textures[object]) albedo[i] *= textures[object]->sample(layer.uv[i], layer.uv_width[i]);
        }
    });
    return albedo;
}

}  // namespace dapple::render
