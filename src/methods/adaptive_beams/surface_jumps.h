#pragma once
#include <optional>
#include <vector>

#include "methods/adaptive_beams/edge_search.h"

namespace dapple::methods::adaptive_beams {

/// Whether the surface that two rays meet first may jump between them, as it does where light grazes a wave
/// and goes on to the next one: where the plane in which one of them meets it is not where the other meets
/// it, to a quarter of the way between the two points. Both meet the body of `view`.
bool may_jump(const LightView& view, const TracedRays& rays, const RayEdge& edge);

/// The last ray before a jump on each edge and the first after it; nothing where the surface only is steep,
/// as before its outline, where depth goes with the root of the distance. New rays are appended to `rays`.
std::vector<std::optional<RayEdge>> surface_jumps(const PathTracer& tracer, TracedRays& rays,
                                                  const std::vector<RayEdge>& edges);

}  // namespace dapple::methods::adaptive_beams
