#pragma once
#include <functional>
#include <glm/glm.hpp>
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

/// For each light of the tracer the tiles of the water and what a ray of them brings to the picture, root
/// mean square. Empty where the user wants to stop.
struct WaterWeights {
    StrataLayout tiles;
    std::vector<double> weights;
};
std::vector<WaterWeights> water_weights(const VolumeJob& job);

/// Traces all lights of one pass and gives S [W/m^2/sr] of each segment in `radiance`, and the number of rays
/// of all lights. Tiles of strata, whose size depends on the number of segments alone, are added in their
/// order, so that the bits do not depend on the number of threads. False, with `radiance` useless, as soon as
/// `stop` says so.
bool run_volume_pass(const VolumeJob& job, LightPass pass, const std::vector<WaterWeights>& weights,
                     std::vector<glm::dvec3>& radiance, std::size_t& rays);

}  // namespace dapple::reference
