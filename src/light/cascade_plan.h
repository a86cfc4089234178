#pragma once
#include <vector>

#include "light/cascade_layout.h"
#include "light/map_plan.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// The maps of one light, the innermost cascade first, without those that have nothing to carry (the camera
/// may stand far from all water). Where the light does not reach the surface: one that is not lit.
///
/// By default the shares of neighbouring cascades pass into each other over ramps (cascade_layout.h) and sum
/// to one at every point, of photons that are `cells`; with `paper_faithful` the boxes are those of Kougianos
/// and Moustakas 2021.
std::vector<MapPlan> plan_cascades(const scene::FrameScene& scene, int light,
                                   const scene::CausticMapParameters& parameters,
                                   PhotonCells cells = PhotonCells::tents);

/// Of the maps of one light, borders left out: to foresee memory.
struct MapTexels {
    double largest = 0;  ///< texels of one map, what its hole holds too
    double all = 0;      ///< texels of all maps
    double photons = 0;  ///< of these, those that are traced
};
MapTexels count_texels(const scene::FrameState& state, const scene::CausticMapParameters& parameters);

}  // namespace dapple::light
