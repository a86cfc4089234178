#pragma once
#include <string>
#include <vector>

#include "light/beam_mesh.h"
#include "methods/caustic_method.h"
#include "render/frame_renderer.h"
#include "scene/frame_scene.h"

namespace dapple::render {

/// What a frame needs, decided from its scene before anything is traced.
struct Plan {
    bool water = false;
    bool caustics = false;             ///< there is a chain to trace for receivers
    std::vector<light::Chain> chains;  ///< for the method's FrameContext
    int buffer_scale = 1;              ///< pixels a side of those that E is found for
    bool flat_water_stand_in = false;  ///< light through water that the method does not look at
    bool direct_light = false;
    bool sky_light = false;
    bool volume = false;           ///< something scatters light, and there is some to scatter
    bool volume_caustics = false;  ///< S: there is a chain to trace for segments
    bool volume_direct = false;    ///< light that met nothing before
    bool half_volume = false;      ///< the two at every second pixel
    std::vector<PlanLine> lines;   ///< what --plan prints
};

/// By the rest plane: what counts for plans.
bool light_above_water(const scene::Light& light);

Plan make_plan(const scene::FrameScene& scene, const methods::CausticMethod& method);

}  // namespace dapple::render
