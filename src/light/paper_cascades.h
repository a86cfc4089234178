#pragma once
#include <vector>

#include "light/map_plan.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// The cascades of Kougianos and Moustakas 2021, section 3.1, as they are but for what breaks a formula: the
/// innermost first, each `cascade_scale` times as wide as the one inside it, seen along the light from about
/// the camera, which they follow without steps; each but the innermost without the middle that the one inside
/// it holds, and with hard borders. For a light that reaches the surface.
std::vector<MapPlan> plan_paper_cascades(const scene::FrameScene& scene, int light,
                                         const scene::CausticMapParameters& parameters);

/// Photons along each side of the map of a cascade.
int paper_side(const scene::FrameState& state, const scene::CausticMapParameters& parameters,
               std::size_t cascade);

/// Equation 3: photons along each side of the innermost map that is `range` m wide, for photons at most
/// `precision` m apart.
int paper_resolution(double range, double precision);

/// Equation 6, in whole texels: width of the frame that is left of a map of `resolution` by `resolution`.
int paper_frame(int resolution, double scale);

}  // namespace dapple::light
