#pragma once
#include "metrics/picture.h"

namespace dapple::metrics {

/// Difference of frame differences, d = (I_t - I_(t-1)) - (R_t - R_(t-1)), over channels and pixels.
struct TemporalDifference {
    double mae = 0;
    double rmse = 0;
};

TemporalDifference temporal_difference(const Picture& before, const Picture& frame,
                                       const Picture& reference_before, const Picture& reference);

}  // namespace dapple::metrics
