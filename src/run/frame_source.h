#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/stats.h"
#include "image/image.h"
#include "methods/caustic_method.h"
#include "render/frame_renderer.h"

namespace dapple::run {

/// Both pictures of one frame.
struct SourceFrame {
    image::Image linear;  ///< scene-linear layers, float
    image::Image graded;  ///< R, G, B and perhaps A, display-referred, half
    render::NonFinite non_finite;
    std::vector<render::PlanLine> plan;  ///< what was done, and why
};

/// Where the frame loop gets its frames from. Every function is pure in `frame`: the loop may ask for any
/// frames in any order and relies on equal bits.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    /// May keep what it has in the checkpoint's file and throw Error(interrupted) when that asks to stop;
    /// with the file or without, the frame gets the same bits.
    virtual SourceFrame render(std::int64_t frame, FrameStats& stats,
                               const methods::Checkpoint& checkpoint) = 0;
    /// Estimated peak memory of a frame in bytes; loads nothing.
    virtual std::size_t bytes(std::int64_t frame) const = 0;
};

}  // namespace dapple::run
