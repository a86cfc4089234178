#include "metrics/band_flicker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace dapple::metrics {
namespace {

constexpr std::size_t kPixels = 300;  // no multiple of what is transformed together
constexpr double kFps = 24;

/// The bands of a clip of `frames` frames.
std::vector<BandFlicker::Band> bands_of(int frames,
                                        const std::function<double(int t, std::size_t pixel)>& value) {
    BandFlicker flicker(kFps);
    std::vector<float> values(kPixels);
    for (int t = 0; t < frames; ++t) {
        for (std::size_t i = 0; i < kPixels; ++i) values[i] = static_cast<float>(value(t, i));
        flicker.add(values);
    }
    return flicker.bands();
}

/// A sine of amplitude `a`, of another phase in every pixel, about 5.
std::vector<BandFlicker::Band> sine_bands(int frames, double hz, double a) {
    return bands_of(frames, [&](int t, std::size_t pixel) {
        return 5 + a * std::sin(2 * std::numbers::pi * (hz * t / kFps + 0.37 * static_cast<double>(pixel)));
    });
}

TEST(BandFlicker, BandsAreOctavesOfHalfTheFrameRate) {
    const auto bands = bands_of(0, {});
    ASSERT_EQ(bands.size(), 4u);
    const double ends[] = {0, 1.5, 3, 6, 12};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(bands[i].low_hz, ends[i]);
        EXPECT_EQ(bands[i].high_hz, ends[i + 1]);
        EXPECT_EQ(bands[i].energy, 0);
    }
}

TEST(BandFlicker, AStillClipHasNone) {
    for (const int frames : {1, 2, 31, 32, 50}) {
        const auto bands =
            bands_of(frames, [](int, std::size_t pixel) { return 0.1 + 1e-3 * static_cast<double>(pixel); });
        for (const BandFlicker::Band& band : bands) EXPECT_EQ(band.energy, 0) << frames;
    }
}

TEST(BandFlicker, ASineIsInItsBandWithHalfItsSquare) {
    // Frequencies of a window of 32 frames, two or more of them from the ends of the band, have nothing in
    // any other; 5 in float is known to 2^-23 of that, which decides what is left elsewhere.
    constexpr double amplitude = 0.5, energy = amplitude * amplitude / 2;
    for (const auto& [step, expected] : {std::pair{6, std::size_t{2}}, {10, 3}, {12, 3}, {14, 3}}) {
        for (const int frames : {32, 64, 75, 160}) {
            const auto bands = sine_bands(frames, step * kFps / 32, amplitude);
            for (std::size_t i = 0; i < bands.size(); ++i) {
                EXPECT_NEAR(bands[i].energy, i == expected ? energy : 0, 1e-6) << step << ' ' << frames;
            }
        }
    }
    // Between those, Hann's side lobes let less than 1 % out.
    for (const double hz : {7.7, 8.9, 10.3})
        EXPECT_NEAR(sine_bands(96, hz, 0.5)[3].energy, energy, 0.01 * energy);
    for (const double hz : {4.5, 4.6}) EXPECT_NEAR(sine_bands(96, hz, 0.5)[2].energy, energy, 0.01 * energy);
}

TEST(BandFlicker, AlternatingFramesAreInTheHighestBandOnly) {
    for (const int frames : {32, 40, 8}) {
        const auto bands = bands_of(frames, [](int t, std::size_t) { return t % 2 == 0 ? 0.25 : -0.25; });
        // The variance of +-a is a^2; in floats.
        EXPECT_NEAR(bands[3].energy, 0.0625, 1e-7) << frames;
        EXPECT_NEAR(bands[0].energy + bands[1].energy + bands[2].energy, 0, 1e-7) << frames;
    }
}

TEST(BandFlicker, OnePixelCountsForItsShare) {
    const auto bands = bands_of(64, [](int t, std::size_t pixel) {
        return pixel == 299 ? std::sin(2 * std::numbers::pi * 12 * t / 32) : 1.0;
    });
    EXPECT_NEAR(bands[3].energy, 0.5 / kPixels, 1e-7);
}

TEST(BandFlicker, TheLastWindowEndsAtTheLastFrame) {
    // Still, but for two flashes in frames 36 and 38 of 45: the whole windows end at frame 31.
    const auto bands = bands_of(45, [](int t, std::size_t) { return t == 36 || t == 38 ? 1.0 : 0.0; });
    double sum = 0;
    for (const BandFlicker::Band& band : bands) sum += band.energy;
    // Of two windows the last one sees it, frames 13 to 44: their variance under Hann's window, by hand.
    double mean = 0, squares = 0, weights = 0, constant = 0;
    for (int t = 0; t < 32; ++t) mean += (t == 23 || t == 25 ? 1.0 : 0.0) / 32;
    for (int t = 0; t < 32; ++t) {
        const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / 32);
        const double value = (t == 23 || t == 25 ? 1.0 : 0.0) - mean;
        squares += window * window * value * value;
        weights += window * window;
        constant += window * value;
    }
    EXPECT_NEAR(sum, (squares - constant * constant / 32) / weights / 2, 1e-6);
}

TEST(BandFlicker, AGapIsNoChange) {
    // Still runs at different levels: joined they would be a step, or a flicker.
    BandFlicker still(kFps), alternating(kFps), mixed(kFps);
    for (int t = 0; t < 60; ++t) {
        if (t == 20 || t == 50) still.gap();
        still.add(std::vector<float>(kPixels, t < 20 ? 1.0f : t < 50 ? 3.0f : 2.0f));
        alternating.gap();  // frames 1, 3, 5 of a clip that are judged alone
        alternating.add(std::vector<float>(kPixels, t % 2 == 0 ? 1.25f : 0.75f));
        // 32 frames alternate, 28 stand still: windows of 32 and 28 frames.
        if (t == 32) mixed.gap();
        mixed.add(std::vector<float>(kPixels, t < 32 && t % 2 == 0 ? 1.25f : 0.75f));
    }
    for (const BandFlicker::Band& band : still.bands()) EXPECT_EQ(band.energy, 0);
    for (const BandFlicker::Band& band : alternating.bands()) EXPECT_EQ(band.energy, 0);
    EXPECT_NEAR(mixed.bands()[3].energy, 0.0625 * 32 / 60, 1e-7);
    // Memory is that of a run's window: pictures of another size may follow.
    mixed.gap();
    mixed.gap();
    mixed.add(std::vector<float>(10, 1.0f));
    EXPECT_NEAR(mixed.bands()[3].energy, 0.0625 * 32 / 60, 1e-7);
}

TEST(BandFlicker, LeavesOutExcludedPixels) {
    BandFlicker with(kFps);
    for (int t = 0; t < 40; ++t) {
        std::vector<float> values(kPixels, 1.0f);
        for (std::size_t i = 0; i < 10; ++i) values[i] = t % 2 == 0 ? 1.25f : 0.75f;
        std::vector<std::uint32_t> excluded;
        if (t == 20) excluded = {3, 200};  // 0 there, which would be a flash
        for (const std::uint32_t pixel : excluded) values[pixel] = 0;
        with.add(values, excluded);
    }
    const auto bands = with.bands();
    EXPECT_NEAR(bands[3].energy, 0.0625 * 9 / (kPixels - 2), 1e-7);
    EXPECT_NEAR(bands[0].energy + bands[1].energy + bands[2].energy, 0, 1e-7);
}

}  // namespace
}  // namespace dapple::metrics
