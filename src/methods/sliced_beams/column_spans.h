#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "media/media.h"

namespace dapple::methods::sliced_beams {

/// Column of a bounded medium along a ray from the water, at points evenly apart where it changes; before the
/// first and after the last of them it is theirs.
struct ColumnSpan {
    float begin = 0;          ///< m of depth from the water
    float inverse_step = 0;   ///< steps a m of depth; 0: all the column is too thin to matter
    std::uint32_t first = 0;  ///< index of the first point
    std::uint32_t last = 1;   ///< index of the last one, from there
    std::uint8_t level = 0;   ///< kLeastSteps 2^level steps
    bool coarse = false;      ///< the points do not tell the column well enough

    bool empty() const { return inverse_step == 0; }

    static constexpr std::uint32_t kLeastSteps = 47;
    static constexpr int kLevels = 5;
    static constexpr std::uint32_t points(int level) { return (kLeastSteps << level) + 1; }
};

/// Optical depth by which a column between two points of a span may be off, in the medium's densest channel.
/// A tenth of it is cut off at either end.
constexpr double kColumnTolerance = 0.005;

/// The span of a component of the profile, with as many points as keep to the tolerance, or with the fewest
/// and coarse. `densest`, `clearest`: extinction of these channels, /m. `stretch`: m of way a m of depth.
ColumnSpan column_span(const media::DensityProfile& profile, std::size_t component, double densest,
                       double clearest, double stretch);

/// Columns at the points of a span of that profile that is not empty, m of way.
void fill_columns(const media::DensityProfile& profile, std::size_t component, double stretch,
                  const ColumnSpan& span, std::span<float> columns);

}  // namespace dapple::methods::sliced_beams
