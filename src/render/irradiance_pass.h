#pragma once
#include <span>

#include "denoise/upsample.h"
#include "methods/caustic_method.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// Luminance of the weakest light, W/m^2 on a plane that faces it; of lamps where the rest plane of the water
/// is nearest to them. Lamps in that plane, and lights that are dark, are left out; 0 where none is left.
float weakest_light(const scene::FrameState& state);

/// E of layers by the method, filtered if the timeline says so, found at `scale` times larger pixels and
/// brought from there to all receivers.
class IrradiancePass {
public:
    /// `context` is of the scene that the method looks at: at_scale() of `scene` where that is more than 1.
    IrradiancePass(methods::CausticMethod& method, methods::FrameContext& context,
                   const scene::FrameScene& scene, int scale);

    /// `coarse` are layers of the same samples and branches of the context's scene; nothing where the scale
    /// is 1.
    void run(std::span<const view::ReceiverLayer> layers, std::span<const view::ReceiverLayer> coarse,
             std::span<methods::LayerResult> results);

private:
    void find(std::span<const view::ReceiverLayer> layers, std::span<methods::LayerResult> results);
    void take_nearest(const view::ReceiverLayer& layer, std::vector<std::size_t> pixels,
                      std::span<const view::ReceiverLayer> coarse, std::span<const denoise::Irradiance> from,
                      std::size_t own, denoise::Irradiance& to);
    void ask_for(std::span<const view::ReceiverLayer> layers,
                 std::span<const std::vector<std::size_t>> pixels, std::span<methods::LayerResult> results);

    methods::CausticMethod& method_;
    methods::FrameContext& context_;
    const scene::FrameScene& scene_;
    int scale_;
};

}  // namespace dapple::render
