#include "metrics/bias_flicker.h"

#include <gtest/gtest.h>

#include <functional>

#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

constexpr int kWidth = 9, kHeight = 7;

Picture grey(float value) {
    return constant(kWidth, kHeight, glm::vec3(value));
}

/// R = 2 in `frames` frames, I = R + error(t).
BiasFlicker split_of(int frames, const std::function<float(int t)>& error) {
    BiasFlicker split;
    for (int t = 0; t < frames; ++t) split.add(grey(2 + error(t)), grey(2));
    return split;
}

TEST(BiasFlicker, AConstantErrorIsStatic) {
    const BiasFlicker split = split_of(7, [](int) { return 0.5f; });
    EXPECT_EQ(split.split().static_error, 0.25 / 4);
    EXPECT_EQ(split.split().flicker_energy, 0);
    EXPECT_EQ(split.deviation_map(), std::vector<float>(kWidth * kHeight, 0.0f));
}

TEST(BiasFlicker, AnAlternatingErrorFlickers) {
    const BiasFlicker split = split_of(8, [](int t) { return t % 2 == 0 ? 0.5f : -0.5f; });
    // Thirds in Welford's means round in doubles.
    EXPECT_NEAR(split.split().static_error, 0, 1e-15);
    EXPECT_NEAR(split.split().flicker_energy, 0.25 / 4, 1e-15);
    for (const float deviation : split.deviation_map()) EXPECT_FLOAT_EQ(deviation, 0.5f);
}

TEST(BiasFlicker, BothAddUpToTheMeanSquare) {
    // Errors of 0, 1/4, 1, 3/4: mean 1/2, mean of squares 13/32, variance 5/32.
    const float errors[] = {0, 0.25f, 1, 0.75f};
    const auto split = split_of(4, [&](int t) { return errors[t]; }).split();
    EXPECT_NEAR(split.static_error, 0.25 / 4, 1e-15);
    EXPECT_NEAR(split.flicker_energy, 5.0 / 32 / 4, 1e-15);
}

TEST(BiasFlicker, LeavesOutExcludedPixelsFrameByFrame) {
    BiasFlicker split;
    for (int t = 0; t < 4; ++t) {
        Picture picture = grey(t % 2 == 0 ? 3 : 1), reference = grey(2);
        for (const std::uint32_t pixel : {5, 40}) {
            // 5 is never counted, 40 in frames 1, 2 and 3.
            if (pixel == 40 && t > 0) continue;
            exclude(picture, pixel);
            exclude(reference, pixel);
        }
        split.add(picture, reference);
    }
    // Pixel 40 has errors -1, 1, -1: mean -1/3, variance 8/9. 61 others have 0 and 1. R^2 is 4 where counted.
    constexpr double pixels = kWidth * kHeight - 1;
    EXPECT_NEAR(split.split().static_error, 1.0 / 9 / pixels / 4, 1e-15);
    EXPECT_NEAR(split.split().flicker_energy, (pixels - 1 + 8.0 / 9) / pixels / 4, 1e-15);
    EXPECT_EQ(split.deviation_map()[5], 0);
    EXPECT_EQ(split.deviation_map()[6], 1);
}

TEST(BiasFlicker, OfNothingIsNothing) {
    const BiasFlicker none;
    EXPECT_EQ(none.split().static_error, 0);
    EXPECT_EQ(none.split().flicker_energy, 0);
    EXPECT_TRUE(none.deviation_map().empty());
}

}  // namespace
}  // namespace dapple::metrics
