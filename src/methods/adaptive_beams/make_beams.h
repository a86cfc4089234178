#pragma once
#include <vector>

#include "methods/adaptive_beams/beam_set.h"
#include "methods/caustic_method.h"

namespace dapple::methods::adaptive_beams {

/// The light side of a frame: beams of all the context's chains, legs and axes, in a fixed order, from a grid
/// projected from each light onto each specular body and refined where it must be (Liktor and Dachsbacher
/// 2011, section 4).
///
/// The first leg of a chain begins after its first event, at glass where light has come out again; where it
/// ends at the water or at glass, what goes through makes a leg of its own, and so on ("sun > ball:TT >
/// water:T"). Legs end on objects, or where nothing beyond can be lit or seen; the rays of a beam end on one
/// object (with `paper_faithful` they may not). A beam of the last level at an outline is cut there, at that
/// of a wave that hides others from a low sun too; with `paper_faithful` it is left out.
///
/// Where the water's dispersion is not 0, what goes through it has paths of its own for red, green and blue.
///
/// Stats: "light on specular surfaces, W" is what the lights send into the chains' first events, but for what
/// media take before; the first legs' flux and all that is "lost ..., W" there add up to it. Later legs carry
/// what legs before them bring, less media and what is "lost ..." there.
std::vector<BeamSet> make_beams(FrameContext& context);

}  // namespace dapple::methods::adaptive_beams
