#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "render/frame_renderer.h"
#include "scene/frame_state.h"

namespace dapple::render {

/// What settling found for one frame of the clip.
struct PilotError {
    std::int64_t frame = 0;
    double error = 0;      ///< of the settings that were chosen: relative L1 of E, an estimate
    double by_mesh = 0;    ///< of it what the water's mesh makes, which no setting of the method changes
    double by_pixels = 0;  ///< of it what the method makes of the pixels' size: the blur of splats
};

/// Settings that were chosen for caustics.target_error.
struct SettledCaustics {
    double target = 0;
    int map_resolution = 0;
    scene::PhotonFootprint footprint = scene::PhotonFootprint::tent;
    int denoise_passes = 1;
    std::vector<PilotError> pilots;
    int finest_tried = 0;           ///< map_resolution
    std::uint64_t most_memory = 0;  ///< bytes foreseen for a pilot with it

    double error() const;  ///< the largest of the pilots'
    bool reached() const { return error() <= target; }
};

/// Puts them in the place of what the timeline leaves open.
void apply(const SettledCaustics& settled, scene::Caustics& caustics);

/// "map_resolution 724, footprint tent": what is chosen for that method, in the keys of a timeline.
std::string settings_text(const SettledCaustics& settled, const scene::Caustics& caustics);
/// A line of the plan: the settings, and the estimates that they were chosen by; "partly" where they miss the
/// target, with what stands in the way.
PlanLine plan_line(const SettledCaustics& settled, const scene::Caustics& caustics);

/// First, middle and last frame of the clip, each once.
std::vector<std::int64_t> pilot_frames(const scene::Clip& clip);

}  // namespace dapple::render
