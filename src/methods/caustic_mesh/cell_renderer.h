#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/caustic_mesh/cell_builder.h"
#include "methods/caustic_method.h"
#include "view/receiver_layer.h"

namespace dapple::methods::caustic_mesh {

/// Draws cells into receiver layers on the device, additively and in their order, so that bits repeat.
class CellRenderer {
public:
    /// Buffers of cells hold no more than `largest_buffer` bytes (at least one cell) and than the device
    /// binds.
    explicit CellRenderer(gpu::Device& device,
                          std::uint64_t largest_buffer = std::numeric_limits<std::uint64_t>::max());
    ~CellRenderer();

    /// Forgets the cells of the last frame.
    void clear();
    /// Takes the cells of one beam mesh, to be drawn after those taken before.
    void add(const Cells& cells);
    std::size_t points() const;
    std::size_t quads() const;
    /// That hold them.
    std::size_t buffers() const;
    /// E of each layer, up to four in one draw; `covered` is set for receivers that the camera sees directly.
    /// `at_point`: E is that at the receivers' points, not the mean over their parts of the picture.
    void render(const scene::FrameScene& scene, bool at_point, std::span<const view::ReceiverLayer> layers,
                std::span<LayerResult> results, FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::caustic_mesh
