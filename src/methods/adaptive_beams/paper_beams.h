#pragma once
#include <cstddef>
#include <vector>

#include "layout/paper_beam.h"
#include "methods/adaptive_beams/beam_set.h"

namespace dapple::methods::adaptive_beams {

/// A set's beams as the paper draws them (Liktor and Dachsbacher 2011, section 4.3), in the set's order.
struct PaperBeams {
    std::vector<layout::PaperBeam> beams;
    /// Beams without flux, since a ray runs along their caustic triangle, or this has no area: such have no
    /// sections parallel to it.
    std::size_t lost = 0;
};
PaperBeams paper_beams(const BeamSet& set);

}  // namespace dapple::methods::adaptive_beams
