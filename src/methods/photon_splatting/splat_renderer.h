#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "layout/splat.h"
#include "methods/caustic_method.h"
#include "methods/photon_splatting/footprint.h"
#include "methods/photon_splatting/splat_builder.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::methods {

/// Draws splats into receiver layers, additively and in a fixed order, so that bits repeat.
class SplatRenderer {
public:
    virtual ~SplatRenderer() = default;

    /// Forgets the splats of the last frame.
    virtual void clear() = 0;
    /// Takes splats, to be drawn after those taken before.
    virtual void add(const Splats& splats) = 0;
    virtual std::size_t points() const = 0;
    virtual std::size_t quads() const = 0;
    /// E of each layer; `covered` is set for receivers that the camera sees directly.
    virtual void render(const scene::FrameScene& scene, const SplatStyle& style,
                        std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                        FrameStats& stats) = 0;
};

/// Whether photon_splatting answers for a receiver, of these view::ReceiverFlags: the camera sees it
/// directly.
inline bool is_splatted(std::uint32_t flags) {
    return (flags & view::kReceiver) != 0 && (flags & view::kBehindSpecular) == 0;
}
/// Of the frame's camera.
layout::SplatPush splat_push(const scene::FrameScene& scene);

/// By the rasteriser of the device, all points before all quads, up to four layers in one draw.
std::unique_ptr<SplatRenderer> device_splat_renderer(gpu::Device& device);
/// `largest_buffer`: bytes, at most Device::largest_storage_range.
std::unique_ptr<SplatRenderer> device_splat_renderer(gpu::Device& device, std::size_t largest_buffer);
/// By the processor, in the order of the stretches. Normals are the receivers' own, which the device has to
/// 2e-4.
std::unique_ptr<SplatRenderer> host_splat_renderer();

}  // namespace dapple::methods
