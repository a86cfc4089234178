#pragma once
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/caustic_method.h"
#include "methods/photon_splatting/footprint.h"
#include "methods/photon_splatting/splat_builder.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::methods {

/// Draws splats into receiver layers on the device, additively and in their order, so that bits repeat.
class SplatRenderer {
public:
    explicit SplatRenderer(gpu::Device& device);
    /// `largest_buffer`: bytes, at most Device::largest_storage_range.
    SplatRenderer(gpu::Device& device, std::size_t largest_buffer);
    ~SplatRenderer();

    /// Forgets the splats of the last frame.
    void clear();
    /// Takes splats, to be drawn after those taken before.
    void add(const Splats& splats);
    std::size_t points() const;
    std::size_t quads() const;
    /// E of each layer, up to four in one draw; `covered` is set for receivers that the camera sees directly.
    void render(const scene::FrameScene& scene, const SplatStyle& style,
                std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods
