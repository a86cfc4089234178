#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "methods/reference/camera_segments.h"
#include "methods/reference/light_tracer.h"

namespace dapple::reference {

/// Of the sums of tiles of strata that wait to be added (more only where one tile is larger).
constexpr std::size_t kWaitingBytes = std::size_t{128} << 20;

/// The light and the camera's side of one layer.
struct VolumeJob {
    const scene::FrameScene& scene;
    const rays::RayScene& rays;
    const LightTracer& tracer;
    const CameraSegments& segments;
    const std::function<bool()>& stop;
};

/// For each source of the tracer the tiles of its strata and what a ray of them brings to the picture, root
/// mean square. Empty where the user wants to stop.
struct SourceWeights {
    StrataLayout tiles;
    std::vector<double> weights;
};
std::vector<SourceWeights> source_weights(const VolumeJob& job);

struct VolumePassResult {
    std::size_t rays = 0;       ///< of all sources
    bool extinguished = false;  ///< events were found where light was dimmed to 0
};

/// Traces all sources of one pass and gives S [W/m^2/sr] of each segment in `radiance`. Tiles of strata,
/// whose size depends on the number of segments alone, are added in their order, so that the bits do not
/// depend on the number of threads. None, with `radiance` useless, as soon as `stop` says so.
std::optional<VolumePassResult> run_volume_pass(const VolumeJob& job, LightPass pass,
                                                const std::vector<SourceWeights>& weights,
                                                std::vector<glm::dvec3>& radiance);

}  // namespace dapple::reference
