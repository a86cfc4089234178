#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "image/image.h"
#include "methods/caustic_method.h"
#include "scene/frame_state.h"

namespace dapple::render {

/// A line of `dapple render --plan`: a pass, whether it runs, and why or why not.
struct PlanLine {
    std::string pass;
    std::string decision;  ///< "yes", "partly" or "no"
    std::string reason;
    bool operator==(const PlanLine&) const = default;
};

/// NaN or infinite values that were replaced by 0 before the frame was handed out.
struct NonFinite {
    std::size_t count = 0;
    std::string first;  ///< "channel x,y", empty where count is 0
};

struct SettleRequest;
struct SettledCaustics;

struct RenderedFrame {
    image::Image linear;  ///< the layers of CONVENTIONS.md, float, scene-linear
    NonFinite non_finite;
    std::vector<PlanLine> plan;  ///< what was run, as by FrameRenderer::plan
};

/// Renders single frames: builds the FrameScene, plans the passes that it needs, runs them, composes. The
/// only place that knows the order of passes. Keeps nothing of a frame but caches of files and of
/// time-independent tables, so that each frame is a pure function of its state. Errors:
/// Error(input_unreadable) for meshes and textures, Error(device).
class FrameRenderer {
public:
    explicit FrameRenderer(gpu::Device& device);
    ~FrameRenderer();

    /// Builds the scene of the frame, traces nothing.
    std::vector<PlanLine> plan(const scene::FrameState& state);
    /// `checkpoint` is the method's; what it throws on a stop, Error(interrupted), passes through.
    RenderedFrame render(const scene::FrameState& state, FrameStats& stats,
                         const methods::Checkpoint& checkpoint = {});
    /// See settle.h; the memory of pilots is that of frames.
    SettledCaustics settle(const SettleRequest& request);
    /// Estimated peak memory of a frame in bytes, without loading anything large. Grids count as much as
    /// their files say: Error(input_unreadable) where one cannot be read.
    std::size_t bytes(const scene::FrameState& state) const;
    /// Memory that a frame may take: grids are not loaded beyond it, whatever their files say.
    void limit_memory(std::size_t most_bytes);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::render
