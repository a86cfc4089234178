#include "render/buffer_scale.h"

#include <cmath>

#include "view/camera.h"

namespace dapple::render {
namespace {

int coarse_size(int size, int scale) {
    return (size + scale - 1) / scale;
}

}  // namespace

int pixels_a_side(scene::BufferScale scale) {
    switch (scale) {
        case scene::BufferScale::full:
            break;
        case scene::BufferScale::half:
            return 2;
        case scene::BufferScale::quarter:
            return 4;
    }
    return 1;
}

scene::FrameState at_scale(const scene::FrameState& state, int scale) {
    scene::FrameState coarse = state;
    scene::Clip& clip = coarse.clip;
    clip.width = coarse_size(clip.width, scale);
    clip.height = coarse_size(clip.height, scale);
    const double height = static_cast<double>(clip.height) * scale / state.clip.height;
    scene::Camera& camera = coarse.camera;
    camera.field_of_view = 2 * std::atan(height * std::tan(0.5 * camera.field_of_view));
    camera.view_height *= height;
    return coarse;
}

scene::FrameScene at_scale(const scene::FrameScene& scene, int scale) {
    scene::FrameScene coarse = scene;
    coarse.state = at_scale(scene.state, scale);
    return coarse;
}

denoise::CoarseGrid coarse_grid(const scene::FrameScene& scene, int scale, int sample) {
    const scene::Clip& clip = scene.state.clip;
    const glm::dvec2 fine(clip.width, clip.height);
    const glm::dvec2 covered = static_cast<double>(scale) *
                               glm::dvec2(coarse_size(clip.width, scale), coarse_size(clip.height, scale));
    const view::Camera::SampleCell cell = view::Camera::sample_cell(sample, clip.samples);
    denoise::CoarseGrid grid;
    grid.scale = scale;
    grid.margin = 0.5 * (covered - fine);
    grid.place = cell.corner + 0.5 * cell.size;
    return grid;
}

}  // namespace dapple::render
