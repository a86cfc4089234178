#pragma once
#include <cstddef>
#include <vector>

#include "metrics/lanes.h"

/// One-dimensional filters with their tails folded. `sources[k]` is the row k steps from the centre, for k of
/// either sign: a picture's rows when filtering down, one row k columns on when filtering across. Counts are
/// rounded up to whole blocks, for which rows must have room.
namespace dapple::metrics {

/// Columns that are in work at once: a weight is loaded once for all of them.
inline constexpr std::size_t kFilterBlock = 4 * kFloatLanes;

/// Sum of weights[|k|] sources[k].
void smooth(float* out, const float* const* sources, std::size_t count, const std::vector<float>& weights);

/// The same by two kernels, the first no longer than the second.
void smooth_by_both(float* short_out, float* long_out, const float* const* sources, std::size_t count,
                    const std::vector<float>& short_weights, const std::vector<float>& long_weights);

/// Sums over k > 0 of edge[k] (sources[k] - sources[-k]) and of
/// point[k] (sources[k] + sources[-k] - 2 sources[0]): where the picture is flat both are exactly 0.
void differentiate(float* edge_out, float* point_out, const float* const* sources, std::size_t count,
                   const std::vector<float>& edge, const std::vector<float>& point);

}  // namespace dapple::metrics
