#include "methods/adaptive_beams/make_beams.h"

namespace dapple::methods::adaptive_beams {

std::vector<BeamSet> make_beams(FrameContext&) {
    return {};
}

}  // namespace dapple::methods::adaptive_beams
