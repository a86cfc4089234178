#pragma once
#include <vector>

#include "methods/adaptive_beams/beam_set.h"
#include "methods/caustic_method.h"

namespace dapple::methods::adaptive_beams {

/// The light side of a frame: beams of all the context's chains, legs and axes, in a fixed order, from a grid
/// projected from each light onto the specular surfaces and refined where it must be (Liktor and Dachsbacher
/// 2011, section 4). What is dropped is counted in the stats by cause.
std::vector<BeamSet> make_beams(FrameContext& context);

}  // namespace dapple::methods::adaptive_beams
