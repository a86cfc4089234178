#pragma once
#include <cstdint>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Difference of frame differences, d = (I_t - I_(t-1)) - (R_t - R_(t-1)), over the three channels of all
/// pixels that none of the pictures excludes; 0 where there is none.
struct TemporalDifference {
    double mae = 0;   ///< mean of |d|
    double rmse = 0;  ///< root of the mean of d^2
};

/// The sizes must agree.
TemporalDifference temporal_difference(const Picture& before, const Picture& frame,
                                       const Picture& reference_before, const Picture& reference);

/// What a clip's changes from frame to frame show beyond those of its reference, to the eye:
/// d = FLIP(I_t, I_(t-1)) - FLIP(R_t, R_(t-1)).
struct DeltaFlip {
    double mean = 0;           ///< of d: above 0 where the clip flickers more than the reference moves
    double mean_absolute = 0;  ///< of |d|
};

/// From the maps of both (metrics/flip.h), over all pixels but the excluded ones.
DeltaFlip delta_flip(const std::vector<float>& map, const std::vector<float>& reference_map,
                     const std::vector<std::uint32_t>& excluded = {});

}  // namespace dapple::metrics
