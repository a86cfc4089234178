#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "methods/adaptive_beams/beam_paths.h"
#include "methods/adaptive_beams/light_view.h"

namespace dapple::methods::adaptive_beams {

/// Rays of one view that have been traced.
struct TracedRays {
    std::vector<glm::dvec2> uv;
    std::vector<VertexPaths> paths;
};

/// A beam on one leg, by its rays.
struct LegBeam {
    std::array<std::uint32_t, 3> rays;
    glm::dvec3 flux;  ///< W a channel
};

/// All beams on one leg of one chain that meet the same later surfaces.
struct LegBeams {
    std::size_t leg = 0;
    std::vector<int> surfaces;  ///< where the legs before ended, as PathLeg::end
    bool in_water = false;
    std::vector<LegBeam> beams;
};

using Losses = std::array<glm::dvec3, kCauses>;  ///< W a channel

/// Which light reaches a body in one view, and what becomes of it.
struct BeamHarvest {
    std::vector<LegBeams> legs;  ///< in the order in which they are met first
    Losses losses{};
    glm::dvec3 incident{0};  ///< W, of light that meets the body and takes the event, if media did not dim it
};

/// Cuts triangles of rays so that the three rays of each piece have one and the same path, and makes beams of
/// the pieces, leg by leg. Where two rays of an edge have different paths, the place between them where the
/// path changes is found by halving; what lies between its two sides, a millionth of the edge, is lost at
/// silhouettes. (Liktor and Dachsbacher 2011, 4.1, leave out the whole triangle; `keep_whole` does so.) An
/// edge is cut in the same places for both its triangles. Triangles are cut as well where one part of the
/// body hides another from the light, as waves do from a low sun (not with `keep_whole`, nor where waves are
/// merged); and where the share of the light that takes the event is uneven over a piece, its flux has the
/// mean by rays within it. New rays are appended to `rays`. `entry`, where it is not empty: by what the flux
/// of each other triangle is multiplied.
BeamHarvest cut_into_beams(const PathTracer& tracer, const LightView& view, light::Event event,
                           std::span<const std::array<std::uint32_t, 3>> triangles, bool keep_whole,
                           TracedRays& rays, std::span<const glm::dvec2> entry = {});

}  // namespace dapple::methods::adaptive_beams
