#pragma once
#include <array>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "methods/adaptive_beams/beam_paths.h"

namespace dapple::methods::adaptive_beams {

/// Three rays of a light, by their (u, v).
using RayTriangle = std::array<glm::dvec2, 3>;

/// Means over triangles of what PathTracer::entries() says of `event`, by the middles of 16 equal parts of
/// each.
std::vector<double> mean_entries(const PathTracer& tracer, light::Event event,
                                 std::span<const RayTriangle> triangles);

}  // namespace dapple::methods::adaptive_beams
