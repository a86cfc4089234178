#include "render/albedo.h"

#include "base/parallel.h"

namespace dapple::render {

std::vector<glm::vec3> find_albedo(const scene::FrameScene& scene, const view::ReceiverLayer& layer,
                                   TextureFiles& files) {
    std::vector<std::shared_ptr<const image::Texture>> textures;
    for (const scene::Object& object : scene.state.objects) {
        textures.push_back(files.get(object.material.texture, scene.state.output));
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
