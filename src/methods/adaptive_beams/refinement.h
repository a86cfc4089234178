#pragma once
#include "methods/adaptive_beams/beam_paths.h"
#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/oracle.h"
#include "methods/adaptive_beams/projected_grid.h"
#include "scene/frame_scene.h"

namespace dapple::methods::adaptive_beams {

/// A projected grid of one view, refined, with the ray of each of its vertices (same numbers; middles of
/// edges that were looked at but not cut have numbers too).
struct RefinedGrid {
    ProjectedGrid grid;
    TracedRays rays;
    std::vector<glm::dvec2> entry;  ///< merge_waves(); empty: 1
};

/// A grid is not refined beyond this, so that many levels over a wide sea need no more memory than there is.
constexpr std::size_t kMostTriangles = 1 << 19;

/// Refines a grid of `cells` x `cells` squares up to `levels` times where the oracle asks for it, without the
/// triangles in which it sees nothing of the body. `pass` may be null: the oracle then is judge().
RefinedGrid refine(const scene::FrameScene& scene, const PathTracer& tracer, int body, int cells, int levels,
                   OraclePass* pass, FrameStats& stats);

}  // namespace dapple::methods::adaptive_beams
