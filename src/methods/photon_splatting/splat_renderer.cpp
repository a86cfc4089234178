#include "methods/photon_splatting/splat_renderer.h"

namespace dapple::methods {

layout::SplatPush splat_push(const scene::FrameScene& scene) {
    const scene::Camera& camera = scene.state.camera;
    const bool perspective = camera.projection == scene::Projection::perspective;
    layout::SplatPush push;
    push.picture = glm::vec2(scene.state.clip.width, scene.state.clip.height);
    push.camera = glm::vec3(perspective ? camera.position - scene.origin
                                        : glm::normalize(camera.position - camera.target));
    push.perspective = perspective ? 1 : 0;
    return push;
}

}  // namespace dapple::methods
