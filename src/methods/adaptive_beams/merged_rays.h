#pragma once
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "methods/adaptive_beams/beam_paths.h"
#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/projected_grid.h"

namespace dapple::methods::adaptive_beams {

/// Gives wide beams the light of the waves within them. Beams that are far off or out of sight are wider than
/// waves, and what their three corners meet says little of those. By the texels of the light's view (`side` x
/// `side` of them), for triangles that hold several, all on the body:
/// * the flux is that of the texels' rays, so that it does not depend on where the grid was refined: the
///   result, an entry a triangle by light::Event, is the mean share of the light that takes the event over
///   that of the corners (1 for other triangles);
/// * where the normals are not those that the corners give, rays of vertices are traced anew as from a
/// surface
///   with the mean normal about them, weighted as a linear interpolation weighs them: the beam then flies as
///   its light does on the whole.
std::vector<glm::dvec2> merge_waves(const PathTracer& tracer, const ProjectedGrid& grid,
                                    std::span<const SurfaceTexel> texels, int side, TracedRays& rays);

}  // namespace dapple::methods::adaptive_beams
