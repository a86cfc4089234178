#pragma once
#include "light/beam_mesh.h"
#include "light/map_plan.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// Flux of one chain through those triangles of the water whose centres project outside the map, in the unit
/// of BeamMesh::lost_flux: what a capped border loses. A sum over triangles in double, without shadows of the
/// waves.
double flux_outside_map(const scene::FrameScene& scene, const MapPlan& plan, int light, Event event);

}  // namespace dapple::light
