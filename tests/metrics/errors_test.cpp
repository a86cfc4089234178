#include "metrics/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "metrics/ffmpeg_figures.h"
#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

// Rounding of doubles over a few thousand terms, with room.
constexpr double kRounding = 1e-12;

TEST(Errors, OfAConstantOffsetAreThatOffset) {
    // I - R = 1/4, 1/2, -1/4 in R, G, B; R = 1. All are exact in float.
    const Picture reference = constant(13, 7, {1, 1, 1}), picture = constant(13, 7, {1.25f, 1.5f, 0.75f});
    const Errors errors = errors_of(picture, reference, 2, 1);
    EXPECT_NEAR(errors.mean, 1, kRounding);
    EXPECT_NEAR(errors.bias, 0.5 / 3, kRounding);
    EXPECT_NEAR(errors.mae, 1.0 / 3, kRounding);
    // Mean of squares: (1/16 + 1/4 + 1/16) / 3 = 1/8. Blocks have the same means as their pixels.
    EXPECT_NEAR(errors.rmse, std::sqrt(0.125), kRounding);
    EXPECT_NEAR(errors.block_rmse, std::sqrt(0.125), kRounding);
    EXPECT_NEAR(errors.relative_mse, 0.125 / 1.01, kRounding);
    EXPECT_NEAR(errors.psnr, 10 * std::log10(4 / 0.125), kRounding);
    EXPECT_EQ(errors.largest, 0.5);
    EXPECT_EQ(errors.largest_pixel, 0u);
    EXPECT_EQ(errors.excluded, 0u);
}

TEST(Errors, OfEqualPicturesAreNone) {
    const Picture picture = eight_bit_scene(9, 9, 1, 0.1f);
    const Errors errors = errors_of(picture, picture, 1, 0.5);
    EXPECT_EQ(errors.rmse, 0);
    EXPECT_EQ(errors.relative_mse, 0);
    EXPECT_EQ(errors.largest, 0);
    EXPECT_EQ(errors.psnr, std::numeric_limits<double>::infinity());
}

TEST(Errors, NoiseAveragesOutOverBlocks) {
    // A chequerboard of +-1/2 has mean 0 over any block of even width.
    const Picture reference = constant(16, 8, {2, 2, 2});
    const Picture board =
        picture_by(16, 8, [](int x, int y) { return glm::vec3((x + y) % 2 == 0 ? 2.5f : 1.5f); });
    const Errors errors = errors_of(board, reference, 1, 2);
    EXPECT_NEAR(errors.rmse, 0.5, kRounding);
    EXPECT_NEAR(errors.block_rmse, 0, kRounding);
    // 5 x 5: one whole block; one of 1 x 4 and one of 4 x 1, of mean 0 too; the corner alone, x + y even:
    // +1/2.
    const Errors odd =
        errors_of(picture_by(5, 5, [](int x, int y) { return glm::vec3((x + y) % 2 == 0 ? 2.5f : 1.5f); }),
                  constant(5, 5, {2, 2, 2}), 1, 2);
    EXPECT_NEAR(odd.block_rmse, std::sqrt(0.25 / 4), kRounding);
}

TEST(Errors, FindTheWorstPixel) {
    // In a tile that is not the first, and in another: the first of both counts. One channel alone carries
    // it.
    const Picture reference = constant(21, 60, {1, 1, 1});
    Picture picture = reference;
    picture.rgb[2][21 * 40 + 17] = -3;
    picture.rgb[0][21 * 43 + 2] = 5;
    picture.rgb[0][21 * 58 + 2] = 5;
    picture.rgb[1][3] = 2;
    const Errors errors = errors_of(picture, reference, 1, 1);
    EXPECT_EQ(errors.largest, 4);
    EXPECT_EQ(errors.largest_pixel, 21u * 40 + 17);
}

TEST(Errors, RelativeErrorsHaveTheClipsFloor) {
    // R = 0 in half the pixels, I - R = 1/4 there; the clip's mean is 2: (1/16) / (0.01 * 4) in half of them.
    const Picture reference = picture_by(8, 8, [](int x, int) { return glm::vec3(x < 4 ? 0.0f : 1.0f); });
    const Picture picture = picture_by(8, 8, [](int x, int) { return glm::vec3(x < 4 ? 0.25f : 1.0f); });
    EXPECT_NEAR(errors_of(picture, reference, 1, 2).relative_mse, 0.5 * (0.0625 / 0.04), kRounding);
}

TEST(Errors, OverBlackPassNoLimit) {
    const Picture black = constant(8, 8, {0, 0, 0}), picture = constant(8, 8, {0.25f, 0, 0});
    const Errors errors = errors_of(picture, black, 1, 0);
    EXPECT_GT(errors.relative_mse, 1e300);
    EXPECT_EQ(errors.relative_bias(), HUGE_VAL);
    EXPECT_EQ(errors.relative_rmse(), HUGE_VAL);
    EXPECT_EQ(errors_of(black, black, 1, 0).relative_mse, 0);
    EXPECT_EQ(errors_of(black, black, 1, 0).relative_rmse(), 0);
    // Layers of signed values: an error is not negative.
    const Picture negative = constant(8, 8, {-1, -1, -1});
    EXPECT_NEAR(errors_of(picture, negative, 1, -1).relative_mae(), (1.25 + 1 + 1) / 3, kRounding);
}

TEST(Errors, LeaveOutExcludedPixels) {
    // Every second column is excluded: all means are those of the others, I - R = 1/2 and R = 1.
    Picture reference = constant(10, 6, {1, 1, 1}), picture = constant(10, 6, {1.5f, 1.5f, 1.5f});
    for (std::uint32_t pixel = 0; pixel < 60; pixel += 2) {
        exclude(reference, pixel);
        exclude(picture, pixel);
    }
    const Errors errors = errors_of(picture, reference, 1, 1);
    EXPECT_EQ(errors.excluded, 30u);
    EXPECT_NEAR(errors.mean, 1, kRounding);
    EXPECT_NEAR(errors.bias, 0.5, kRounding);
    EXPECT_NEAR(errors.mae, 0.5, kRounding);
    EXPECT_NEAR(errors.rmse, 0.5, kRounding);
    EXPECT_NEAR(errors.block_rmse, 0.5, kRounding);
    EXPECT_NEAR(errors.relative_mse, 0.25 / 1.01, kRounding);
    EXPECT_NEAR(errors.psnr, 10 * std::log10(4), kRounding);
}

TEST(Errors, LeaveOutBlocksThatAreExcluded) {
    // The left block of two is gone; the other has mean 1/2.
    Picture reference = constant(8, 4, {1, 1, 1}), picture = constant(8, 4, {1.5f, 1.5f, 1.5f});
    for (std::uint32_t pixel = 0; pixel < 32; ++pixel) {
        if (pixel % 8 >= 4) continue;
        exclude(reference, pixel);
        exclude(picture, pixel);
    }
    EXPECT_NEAR(errors_of(picture, reference, 1, 1).block_rmse, 0.5, kRounding);
}

TEST(Errors, OfNothingAreNone) {
    Picture picture = constant(1, 1, {1, 1, 1});
    exclude(picture, 0);
    const Errors errors = errors_of(picture, picture, 1, 1);
    EXPECT_EQ(errors.rmse, 0);
    EXPECT_EQ(errors.block_rmse, 0);
    EXPECT_EQ(errors.excluded, 1u);
}

TEST(Errors, AgreeWithFfmpegsPsnr) {
    // ffmpeg prints six decimals, of squares of whole code values; ours are these over 255 in float, to 1e-7.
    const Picture picture = eight_bit_scene(203, 117, 1, 0.2f),
                  reference = eight_bit_scene(203, 117, 2, 0.1f);
    EXPECT_NEAR(errors_of(picture, reference, 1, 0.5).psnr, ffmpeg_figures(picture, reference).psnr, 2e-6);
}

}  // namespace
}  // namespace dapple::metrics
