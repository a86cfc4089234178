#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "methods/adaptive_beams/beam_pieces.h"

namespace dapple::methods::adaptive_beams {

/// Two rays, by their numbers: first and second end.
using RayEdge = std::array<std::uint32_t, 2>;

/// Whether `probe`, a ray half way between `ends`, the two of `edge` that are known so far, is like the first
/// of them rather than the second; nothing where that cannot be said: they are then as near as they get.
using LikeFirst =
    std::function<std::optional<bool>(const RayEdge& edge, const RayEdge& ends, std::uint32_t probe)>;

/// The last ray like each edge's first end, and one beyond it that is not, by halving; a millionth of the
/// edge apart. New rays are appended to `rays`.
std::vector<RayEdge> halve(const PathTracer& tracer, TracedRays& rays, const std::vector<RayEdge>& edges,
                           const LikeFirst& like_first);

}  // namespace dapple::methods::adaptive_beams
