#pragma once
#include <string>
#include <vector>

#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/beam_set.h"

namespace dapple::methods::adaptive_beams {

/// Appends sets of the beams about as many axes as they need: the mean direction of their flux, and those of
/// light::sheet_axes where its cone does not hold all three rays of a beam. What fits no cone is added to
/// `losses`. `light`: index into FrameState::lights.
void append_sets(const LegBeams& legs, light::Event event, const TracedRays& rays, int light,
                 const std::string& name, std::vector<BeamSet>& sets, Losses& losses);

}  // namespace dapple::methods::adaptive_beams
