#include "render/albedo.h"

#include "base/parallel.h"
#include "render/texture_files.h"

namespace dapple::render {

struct AlbedoSource::State {
    TextureFiles textures;
};

AlbedoSource::AlbedoSource() : state_(std::make_unique<State>()) {}
AlbedoSource::~AlbedoSource() = default;

std::vector<glm::vec3> AlbedoSource::albedo(const scene::FrameScene& scene,
                                            const view::ReceiverLayer& layer) {
    std::vector<std::shared_ptr<const image::Texture>> textures;
    for (const scene::Object& object : scene.state.objects) {
        textures.push_back(state_->textures.get(object.material.texture, scene.state.output));
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
