#include "metrics/differences.h"

#include <cassert>
#include <cmath>

#include "metrics/counted.h"

namespace dapple::metrics {
namespace {

struct Sums {
    double sum = 0, absolute = 0, squares = 0;

    void add(double difference) {
        sum += difference;
        absolute += std::abs(difference);
        squares += difference * difference;
    }
    void operator+=(const Sums& other) {
        sum += other.sum;
        absolute += other.absolute;
        squares += other.squares;
    }
};

}  // namespace

TemporalDifference temporal_difference(const Picture& before, const Picture& frame,
                                       const Picture& reference_before, const Picture& reference) {
    for ([[maybe_unused]] const Picture* other : {&before, &reference_before, &reference}) {
        assert(other->width == frame.width && other->height == frame.height);
    }
    const std::vector<std::uint32_t> excluded =
        excluded_by_any({&before, &frame, &reference_before, &reference});
    const std::size_t counted = frame.pixels() - excluded.size();
    if (counted == 0) return {};
    Sums sums;
    for (std::size_t c = 0; c < 3; ++c) {
        const float *i1 = frame.rgb[c].data(), *i0 = before.rgb[c].data();
        const float *r1 = reference.rgb[c].data(), *r0 = reference_before.rgb[c].data();
        sums +=
            sum_counted<Sums>(frame.pixels(), excluded, [&](Sums& tile, std::size_t first, std::size_t last) {
                for (std::size_t i = first; i < last; ++i) {
                    const double change = static_cast<double>(i1[i]) - static_cast<double>(i0[i]);
                    tile.add(change - (static_cast<double>(r1[i]) - static_cast<double>(r0[i])));
                }
            });
    }
    const double count = 3 * static_cast<double>(counted);
    return {sums.absolute / count, std::sqrt(sums.squares / count)};
}

DeltaFlip delta_flip(const std::vector<float>& map, const std::vector<float>& reference_map,
                     const std::vector<std::uint32_t>& excluded) {
    assert(map.size() == reference_map.size());
    const std::size_t counted = map.size() - excluded.size();
    if (counted == 0) return {};
    const auto sums =
        sum_counted<Sums>(map.size(), excluded, [&](Sums& tile, std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                tile.add(static_cast<double>(map[i]) - static_cast<double>(reference_map[i]));
            }
        });
    return {sums.sum / static_cast<double>(counted), sums.absolute / static_cast<double>(counted)};
}

}  // namespace dapple::metrics
