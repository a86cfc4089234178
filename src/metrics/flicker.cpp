#include "metrics/flicker.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

#include "metrics/counted.h"
#include "metrics/share.h"

namespace dapple::metrics {
namespace {

constexpr int kLowestExponent = -100, kHighestExponent = 100;  // of 2, of H^2
constexpr int kBinsPerOctave = 4;
constexpr std::size_t kBins = kHistogramBins;
static_assert(kBins == kBinsPerOctave * (kHighestExponent - kLowestExponent) + 2);
constexpr std::size_t kJumpBins = 40;
static_assert(kJump == 1 << (kJumpBins / kBinsPerOctave));

/// End of a bin.
double upper_end(std::size_t bin) {
    return std::exp2(static_cast<double>(bin) / kBinsPerOctave + kLowestExponent);
}

/// By exponent and mantissa, which costs less than a logarithm. `term` is not negative.
std::size_t bin_of(double term) {
    constexpr int mantissa_bits = 52, exponent_bias = 1023;
    const auto mantissa_of = [](double value) {
        return std::bit_cast<std::uint64_t>(value) & ((std::uint64_t{1} << mantissa_bits) - 1);
    };
    static constexpr double quarters[] = {1.1892071150027210667, 1.4142135623730950488,
                                          1.6817928305074290861};  // 2^(1/4), 2^(2/4), 2^(3/4)
    const auto exponent =
        static_cast<int>(std::bit_cast<std::uint64_t>(term) >> mantissa_bits) - exponent_bias;
    if (exponent < kLowestExponent) return 0;
    if (exponent >= kHighestExponent) return kBins - 1;
    const std::uint64_t mantissa = mantissa_of(term);
    int bin = kBinsPerOctave * (exponent - kLowestExponent) + 1;
    for (const double quarter : quarters) bin += mantissa >= mantissa_of(quarter) ? 1 : 0;
    return static_cast<std::size_t>(bin);
}

struct Sums {
    double change_before = 0, change_after = 0, high_pass_energy = 0;
    std::array<std::uint32_t, kBins> histogram{};

    void add(double before, double value, double after) {
        const double high_pass = value - (before + after) / 2;
        const double term = high_pass * high_pass;
        change_before += std::abs(value - before);
        change_after += std::abs(after - value);
        high_pass_energy += term;
        ++histogram[bin_of(term)];
    }
    void operator+=(const Sums& other) {
        change_before += other.change_before;
        change_after += other.change_after;
        high_pass_energy += other.high_pass_energy;
        for (std::size_t bin = 0; bin < kBins; ++bin) histogram[bin] += other.histogram[bin];
    }
};

struct Luminances {
    double sum = 0;
    void operator+=(const Luminances& other) { sum += other.sum; }
};

/// `value(plane, pixel)`: D of the frame before (0), of the frame (1), after it (2).
template <typename Value>
FrameFlicker flicker_of(const Picture& frame, const std::vector<std::uint32_t>& excluded,
                        const Value& value) {
    FrameFlicker flicker = lone_frame(frame);
    const auto sums =
        sum_counted<Sums>(frame.pixels(), excluded, [&](Sums& tile, std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) tile.add(value(0, i), value(1, i), value(2, i));
        });
    const double counted = static_cast<double>(std::max<std::size_t>(1, frame.pixels() - excluded.size()));
    flicker.change_before = sums.change_before / counted;
    flicker.change_after = sums.change_after / counted;
    flicker.high_pass_energy = sums.high_pass_energy / counted;
    flicker.excluded = excluded.size();
    std::size_t used = kBins;
    while (used > 1 && sums.histogram[used - 1] == 0) --used;
    flicker.histogram.assign(sums.histogram.begin(), sums.histogram.begin() + static_cast<long>(used));
    return flicker;
}

std::uint64_t sum_from(const std::vector<std::uint32_t>& histogram, std::size_t first_bin) {
    std::uint64_t sum = 0;
    for (std::size_t bin = first_bin; bin < histogram.size(); ++bin) sum += histogram[bin];
    return sum;
}

/// The bin with the median of all frames' terms; 0 where there is none.
std::size_t median_bin(const std::map<std::int64_t, FrameFlicker>& frames) {
    std::array<std::uint64_t, kBins> histogram{};
    std::uint64_t total = 0;
    for (const auto& [number, frame] : frames) {
        assert(frame.histogram.size() <= kBins);
        for (std::size_t bin = 0; bin < frame.histogram.size(); ++bin) histogram[bin] += frame.histogram[bin];
        total += sum_from(frame.histogram, 0);
    }
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
        below += histogram[bin];
        if (2 * below >= total) return bin;
    }
    return 0;
}

}  // namespace

FrameFlicker lone_frame(const Picture& frame) {
    const auto luminances = sum_counted<Luminances>(
        frame.pixels(), frame.excluded, [&](Luminances& tile, std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) tile.sum += static_cast<double>(frame.luminance[i]);
        });
    FrameFlicker flicker;
    flicker.mean = luminances.sum / static_cast<double>(std::max<std::size_t>(1, frame.counted()));
    flicker.excluded = frame.excluded.size();
    return flicker;
}

FrameFlicker frame_flicker(const Picture& before, const Picture& frame, const Picture& after) {
    assert(before.luminance.size() == frame.luminance.size());
    assert(after.luminance.size() == frame.luminance.size());
    const float* planes[] = {before.luminance.data(), frame.luminance.data(), after.luminance.data()};
    return flicker_of(
        frame, excluded_by_any({&before, &frame, &after}),
        [&](std::size_t plane, std::size_t pixel) { return static_cast<double>(planes[plane][pixel]); });
}

FrameFlicker frame_flicker(const Picture& before, const Picture& frame, const Picture& after,
                           const Picture& reference_before, const Picture& reference,
                           const Picture& reference_after) {
    for ([[maybe_unused]] const Picture* other :
         {&before, &after, &reference_before, &reference, &reference_after}) {
        assert(other->luminance.size() == frame.luminance.size());
    }
    const float* planes[] = {before.luminance.data(), frame.luminance.data(), after.luminance.data()};
    const float* references[] = {reference_before.luminance.data(), reference.luminance.data(),
                                 reference_after.luminance.data()};
    return flicker_of(
        frame, excluded_by_any({&before, &frame, &after, &reference_before, &reference, &reference_after}),
        [&](std::size_t plane, std::size_t pixel) {
            return static_cast<double>(planes[plane][pixel]) - static_cast<double>(references[plane][pixel]);
        });
}

ClipFlicker clip_flicker(const std::map<std::int64_t, FrameFlicker>& frames) {
    ClipFlicker clip;
    if (frames.empty()) return clip;
    for (const auto& [number, frame] : frames) clip.mean += frame.mean;
    clip.mean /= static_cast<double>(frames.size());

    const std::size_t median = median_bin(frames);
    clip.median_term = median > 0 ? upper_end(median) : 0;
    const double least = 1e-4 * clip.mean;
    const std::size_t jump_bin = std::min(std::max(median, bin_of(least * least)) + kJumpBins, kBins - 1);
    clip.jump_term = upper_end(jump_bin);
    for (const auto& [number, frame] : frames) {
        const std::uint64_t counted = sum_from(frame.histogram, 0);
        if (frame.histogram.empty()) continue;
        const double flicker = share_of(frame.high_pass_energy, clip.mean * clip.mean);
        const auto jumping = static_cast<double>(sum_from(frame.histogram, jump_bin + 1));
        clip.frames[number] = {flicker, share_of(jumping, static_cast<double>(counted))};
        clip.flicker += flicker;
        if (!clip.worst_frame || flicker > clip.frames[*clip.worst_frame].flicker) clip.worst_frame = number;
    }
    if (!clip.frames.empty()) clip.flicker /= static_cast<double>(clip.frames.size());
    return clip;
}

}  // namespace dapple::metrics
