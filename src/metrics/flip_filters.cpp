#include "metrics/flip_filters.h"

#include <cassert>

namespace dapple::metrics {
namespace {

constexpr std::size_t kVectors = kFilterBlock / kFloatLanes;

/// The rows at k steps to both sides, from column x on.
struct Sides {
    const float* before;
    const float* after;

    Sides(const float* const* sources, std::size_t k, std::size_t x)
        : before(sources[-static_cast<std::ptrdiff_t>(k)] + x), after(sources[k] + x) {}
    Floats sum(std::size_t i) const { return load(before + i * kFloatLanes) + load(after + i * kFloatLanes); }
};

}  // namespace

void smooth(float* out, const float* const* sources, std::size_t count, const std::vector<float>& weights) {
    for (std::size_t x = 0; x < count; x += kFilterBlock) {
        Floats sums[kVectors];
        for (std::size_t i = 0; i < kVectors; ++i) {
            sums[i] = all(weights[0]) * load(sources[0] + x + i * kFloatLanes);
        }
        for (std::size_t k = 1; k < weights.size(); ++k) {
            const Sides sides(sources, k, x);
            const Floats weight = all(weights[k]);
            for (std::size_t i = 0; i < kVectors; ++i) sums[i] = fma(weight, sides.sum(i), sums[i]);
        }
        for (std::size_t i = 0; i < kVectors; ++i) store(out + x + i * kFloatLanes, sums[i]);
    }
}

void smooth_by_both(float* short_out, float* long_out, const float* const* sources, std::size_t count,
                    const std::vector<float>& short_weights, const std::vector<float>& long_weights) {
    assert(short_weights.size() <= long_weights.size());
    for (std::size_t x = 0; x < count; x += kFilterBlock) {
        Floats short_sums[kVectors], long_sums[kVectors];
        for (std::size_t i = 0; i < kVectors; ++i) {
            const Floats centre = load(sources[0] + x + i * kFloatLanes);
            short_sums[i] = all(short_weights[0]) * centre;
            long_sums[i] = all(long_weights[0]) * centre;
        }
        for (std::size_t k = 1; k < short_weights.size(); ++k) {
            const Sides sides(sources, k, x);
            const Floats short_weight = all(short_weights[k]), long_weight = all(long_weights[k]);
            for (std::size_t i = 0; i < kVectors; ++i) {
                const Floats both = sides.sum(i);
                short_sums[i] = fma(short_weight, both, short_sums[i]);
                long_sums[i] = fma(long_weight, both, long_sums[i]);
            }
        }
        for (std::size_t k = short_weights.size(); k < long_weights.size(); ++k) {
            const Sides sides(sources, k, x);
            const Floats weight = all(long_weights[k]);
            for (std::size_t i = 0; i < kVectors; ++i) long_sums[i] = fma(weight, sides.sum(i), long_sums[i]);
        }
        for (std::size_t i = 0; i < kVectors; ++i) {
            store(short_out + x + i * kFloatLanes, short_sums[i]);
            store(long_out + x + i * kFloatLanes, long_sums[i]);
        }
    }
}

void differentiate(float* edge_out, float* point_out, const float* const* sources, std::size_t count,
                   const std::vector<float>& edge, const std::vector<float>& point) {
    assert(edge.size() == point.size());
    constexpr std::size_t kPart = 2;  // vectors at once: more would not fit the registers
    for (std::size_t x = 0; x < count; x += kPart * kFloatLanes) {
        Floats twice[kPart], edges[kPart], points[kPart];
        for (std::size_t i = 0; i < kPart; ++i) {
            const Floats centre = load(sources[0] + x + i * kFloatLanes);
            twice[i] = centre + centre;
            edges[i] = points[i] = all(0);
        }
        for (std::size_t k = 1; k < edge.size(); ++k) {
            const Sides sides(sources, k, x);
            const Floats edge_weight = all(edge[k]), point_weight = all(point[k]);
            for (std::size_t i = 0; i < kPart; ++i) {
                const Floats before = load(sides.before + i * kFloatLanes);
                const Floats after = load(sides.after + i * kFloatLanes);
                edges[i] = fma(edge_weight, after - before, edges[i]);
                points[i] = fma(point_weight, before + after - twice[i], points[i]);
            }
        }
        for (std::size_t i = 0; i < kPart; ++i) {
            store(edge_out + x + i * kFloatLanes, edges[i]);
            store(point_out + x + i * kFloatLanes, points[i]);
        }
    }
}

}  // namespace dapple::metrics
