#include "render/pilot_frame.h"

#include <span>

#include "render/buffer_scale.h"
#include "render/irradiance_pass.h"
#include "view/camera_paths.h"

namespace dapple::render {

bool PixelSurface::same_face(const PixelSurface& other) const {
    constexpr float kHardlyTurned = 0.98f;  // cosine: 11 degrees
    return object != kMixed && object == other.object && glm::dot(normal, other.normal) > kHardlyTurned;
}

PilotFrame::PilotFrame(const scene::FrameState& state, FrameSceneBuilder& builder,
                       methods::CausticMethod& method, gpu::Device& device, FrameStats& stats)
    : method_(method),
      device_(device),
      stats_(stats),
      scene_(builder.build(state)),
      plan_(make_plan(scene_, method)),
      rays_(scene_),
      picture_(look(1)) {}

PilotFrame::View PilotFrame::look(int scale) {
    View view{scale == 1 ? scene_ : at_scale(scene_, scale), {}};
    if (!plan_.caustics) return view;
    for (int sample = 0; sample < scene_.state.clip.samples; ++sample) {
        view::LayerCounts counts;
        view.layers.push_back(view::trace_layer(view.scene, rays_, {sample, 0}, counts));
    }
    return view;
}

std::vector<PixelSurface> PilotFrame::surfaces() const {
    std::vector<PixelSurface> surfaces(picture_.layers.empty() ? 0 : picture_.layers.front().pixels());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        PixelSurface shown;
        for (const view::ReceiverLayer& layer : picture_.layers) {
            PixelSurface path{PixelSurface::kMixed, layer.geometric_normal[i]};
            if ((layer.flags[i] & view::kReceiver) != 0) path.object = layer.object[i];
            if (&layer == picture_.layers.data()) shown = path;
            if (!shown.same_face(path)) shown.object = PixelSurface::kMixed;
        }
        surfaces[i] = shown;
    }
    return surfaces;
}

PixelIrradiance PilotFrame::irradiance(const scene::Caustics& settings) {
    const std::vector<view::ReceiverLayer>& layers = picture_.layers;
    const std::size_t pixels = static_cast<std::size_t>(scene_.state.clip.width) *
                               static_cast<std::size_t>(scene_.state.clip.height);
    PixelIrradiance mean{std::vector<glm::vec3>(pixels, glm::vec3(0)), std::vector<std::uint8_t>(pixels, 0)};
    if (!plan_.caustics) return mean;
    const int scale = settings.buffer_scale == scene::BufferScale::full ? 1 : plan_.buffer_scale;
    if (scale > 1 && !buffer_) buffer_ = look(scale);
    scene_.state.caustics = settings;
    View& asked = scale > 1 ? *buffer_ : picture_;
    asked.scene.state.caustics = settings;
    methods::FrameContext context{asked.scene, rays_, device_, stats_, plan_.chains};
    method_.begin(context);
    IrradiancePass pass(method_, context, scene_, scale);
    std::vector<methods::LayerResult> results(
        layers.size(), {std::vector<glm::vec3>(pixels, glm::vec3(0)), std::vector<std::uint8_t>(pixels, 0)});
    pass.run(layers, scale > 1 ? std::span(buffer_->layers) : std::span<const view::ReceiverLayer>(),
             results);
    for (std::size_t i = 0; i < pixels; ++i) {
        float covered = 0;
        for (const methods::LayerResult& result : results) {
            if (result.covered[i] == 0) continue;
            mean.values[i] += result.irradiance[i];
            covered += 1;
        }
        if (covered == 0) continue;
        mean.values[i] /= covered;
        mean.covered[i] = 1;
    }
    return mean;
}

}  // namespace dapple::render
