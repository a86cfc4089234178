#pragma once
#include <cstdint>
#include <memory>

#include "render/texture_files.h"
#include "scene/frame_scene.h"

namespace dapple::render {

/// Makes the geometry of a frame from its state. Keeps files and time-independent tables between frames (of
/// grids those of the frame before); what it keeps never changes the result. Errors: Error(input_unreadable);
/// Error(out_of_memory_budget) for grids.
class FrameSceneBuilder {
public:
    FrameSceneBuilder();
    ~FrameSceneBuilder();
    scene::FrameScene build(const scene::FrameState& state);

    /// The pictures that it has read, for all who need some. No estimate of memory counts them: 16 B a pixel
    /// with their levels.
    TextureFiles& textures();

    /// Memory that the grids of a frame may take, 4 GiB unless it is said.
    void limit_grids(std::uint64_t most_bytes);
    /// Memory that they take while they are loaded, as their files say, with the dense bricks that
    /// adaptive_beams makes of them; voxels are not read. The errors of build() where a file cannot be read.
    std::uint64_t grid_bytes(const scene::FrameState& state);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::render
