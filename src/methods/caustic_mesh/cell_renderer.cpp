#include "methods/caustic_mesh/cell_renderer.h"

#include "methods/caustic_mesh/picture_map.h"
#include "view/camera.h"

namespace dapple::methods::caustic_mesh {
namespace {

constexpr float kPoint = 1e-3f;  // pixels: width of a filter that is as good as none

}  // namespace

layout::MeshPush mesh_push(const scene::FrameScene& scene) {
    const PictureMap picture(scene);
    layout::MeshPush push;
    push.row_x = picture.rows()[0];
    push.row_y = picture.rows()[1];
    push.row_w = picture.rows()[2];
    push.picture = glm::vec2(scene.state.clip.width, scene.state.clip.height);
    return push;
}

glm::vec4 filter_of(int sample, int samples, bool at_point) {
    if (at_point) return {0, 0, kPoint, kPoint};
    const view::Camera::SampleCell cell = view::Camera::sample_cell(sample, samples);
    const glm::dvec2 middle = cell.corner + 0.5 * cell.size - view::Camera::sample_offset(sample, samples);
    return {glm::vec2(middle), glm::vec2(cell.size)};
}

}  // namespace dapple::methods::caustic_mesh
