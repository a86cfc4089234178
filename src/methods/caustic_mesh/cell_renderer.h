#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "layout/mesh_cell.h"
#include "methods/caustic_mesh/cell_builder.h"
#include "methods/caustic_method.h"
#include "view/receiver_layer.h"

namespace dapple::methods::caustic_mesh {

/// Draws cells into receiver layers, additively and in a fixed order, so that bits repeat.
class CellRenderer {
public:
    virtual ~CellRenderer() = default;

    /// Forgets the cells of the last frame.
    virtual void clear() = 0;
    /// Takes the cells of one beam mesh, to be drawn after those taken before.
    virtual void add(const Cells& cells) = 0;
    virtual std::size_t points() const = 0;
    virtual std::size_t quads() const = 0;
    /// E of each layer; `covered` is set for receivers that the camera sees directly. `at_point`: E is that
    /// at the receivers' points, not the mean over their parts of the picture.
    virtual void render(const scene::FrameScene& scene, bool at_point,
                        std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                        FrameStats& stats) = 0;
};

/// Whether caustic_mesh answers for a receiver, of these view::ReceiverFlags: the camera sees it directly, in
/// the air or in the water.
inline bool is_lit_by_cells(std::uint32_t flags) {
    return (flags & view::kReceiver) != 0 && (flags & (view::kBehindSpecular | view::kInGlass)) == 0;
}
/// Of the frame's camera, without filters.
layout::MeshPush mesh_push(const scene::FrameScene& scene);
/// Middle of the filter from the sample's point, and its size, pixels.
glm::vec4 filter_of(int sample, int samples, bool at_point);

/// By the rasteriser of the device, all points before all quads, up to four layers in one draw. Buffers of
/// cells hold no more than `largest_buffer` bytes (at least one cell) and than the device binds.
std::unique_ptr<CellRenderer> device_cell_renderer(
    gpu::Device& device, std::uint64_t largest_buffer = std::numeric_limits<std::uint64_t>::max());
/// By the processor.
std::unique_ptr<CellRenderer> host_cell_renderer();

}  // namespace dapple::methods::caustic_mesh
