#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "gpu/device.h"
#include "methods/caustic_method.h"
#include "render/frame_scene_builder.h"
#include "render/settled_caustics.h"
#include "scene/frame_state.h"

namespace dapple::render {

struct SettleRequest {
    std::vector<scene::FrameState> pilots;   ///< at least one; their caustics are equal but for keyed numbers
    bool choose_footprint = false;           ///< of photon_splatting: the timeline leaves it open
    bool choose_passes = false;              ///< of the filter that the timeline asks for
    std::uint64_t most_memory = UINT64_MAX;  ///< bytes
    std::function<std::uint64_t(const scene::FrameState&)> memory;  ///< foreseen for a frame, bytes
    std::function<bool()> stop = [] { return false; };              ///< asked between settings
};

/// The cheapest settings whose error is within FrameState::caustics.target_error in all pilots, by estimates
/// of the method's own. Each pilot is rendered (E only, one camera path a pixel of the clip's own size:
/// pixels are means, so that fewer of them would show less of the error) by maps of 64, 128, 256... photons a
/// side, until the error that three of them tell (error_estimate.h) is small enough; between these the error
/// follows a power law. Maps do not see the mesh of the water, whose error is of second order: by one of half
/// as many cells each way, a third of the difference. The two add up as squares.
///
/// Pure in the pilots: the limits are the same on all machines (kFinestMap; kMostMapMemory for the method);
/// where nothing within them does, the settings are the best that there are. Throws
/// Error(out_of_memory_budget) where more than `most_memory` would be needed, Error(interrupted) where asked
/// to stop, and what building a frame throws.
SettledCaustics settle(const SettleRequest& request, FrameSceneBuilder& builder,
                       methods::CausticMethod& method, gpu::Device& device);

constexpr int kCoarsestMap = 64;                                  ///< map_resolution tried first
constexpr int kFinestMap = 8192;                                  ///< tried last
constexpr std::uint64_t kMostMapMemory = std::uint64_t{4} << 30;  ///< bytes that the method may take

}  // namespace dapple::render
