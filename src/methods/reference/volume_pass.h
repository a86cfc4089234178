#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/camera_segments.h"
#include "methods/reference/light_tracer.h"

namespace dapple::reference {

/// Traces all lights of one pass and gives S [W/m^2/sr] of each segment in `radiance`. Tiles of strata, whose
/// size depends on the number of segments alone, are added in their order, so that the bits do not depend on
/// the number of threads. False, with `radiance` useless, as soon as `stop` says so.
bool run_volume_pass(const scene::FrameScene& scene, const rays::RayScene& rays, const LightTracer& tracer,
                     const LightPass& pass, const CameraSegments& segments, const std::function<bool()>& stop,
                     std::vector<glm::dvec3>& radiance);

}  // namespace dapple::reference
