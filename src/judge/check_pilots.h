#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "judge/check.h"
#include "judge/sequence.h"

namespace dapple::judge {

/// First, middle and last of frames in ascending order, each once.
std::vector<std::int64_t> pilot_frames(const std::vector<std::int64_t>& frames);

/// What is fixed for a clip before its frames are judged one after the other: from the pilots, the first, the
/// middle and the last frame wanted that are there.
struct Pilots {
    double level = 0;           ///< largest of their mean luminances
    double reference_mean = 0;  ///< mean of the reference's R, G and B
    std::optional<metrics::Exposures> exposures;
};

/// Exposures are of linear references only. Pilots that cannot be read are passed over; where there is none
/// everything is 0. The CPU seconds of reading them are added to `decode_cpu_s`.
Pilots read_pilots(const Sequence& sequence, const Sequence* reference,
                   const std::vector<std::int64_t>& frames, const CheckOptions& options,
                   double& decode_cpu_s);

}  // namespace dapple::judge
