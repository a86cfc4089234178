#include "metrics/ssim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "metrics/ffmpeg_figures.h"
#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

constexpr SsimOptions kBoxes{.window = SsimWindow::boxes};

/// Wang et al. 2004, equations 13 to 16, for one window straight from the definition.
double window_ssim(const Picture& picture, const Picture& reference, int left, int top) {
    double weights = 0, mean_a = 0, mean_b = 0;
    const auto weight = [](int dx, int dy) { return std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5)); };
    const auto each = [&](auto&& body) {
        for (int y = 0; y < 11; ++y) {
            for (int x = 0; x < 11; ++x) {
                const auto i = static_cast<std::size_t>((top + y) * picture.width + left + x);
                body(weight(x - 5, y - 5), picture.luminance[i], reference.luminance[i]);
            }
        }
    };
    each([&](double w, double a, double b) {
        weights += w;
        mean_a += w * a;
        mean_b += w * b;
    });
    mean_a /= weights;
    mean_b /= weights;
    double variance_a = 0, variance_b = 0, covariance = 0;
    each([&](double w, double a, double b) {
        variance_a += w / weights * (a - mean_a) * (a - mean_a);
        variance_b += w / weights * (b - mean_b) * (b - mean_b);
        covariance += w / weights * (a - mean_a) * (b - mean_b);
    });
    const double c1 = 1e-4, c2 = 9e-4;
    return (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
           ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
}

TEST(Ssim, OfEqualPicturesIsOne) {
    const Picture picture = eight_bit_scene(40, 30, 1, 0.3f);
    EXPECT_NEAR(ssim(picture, picture, {}), 1, 1e-12);
    EXPECT_NEAR(ssim(picture, picture, kBoxes), 1, 1e-12);
}

TEST(Ssim, OfTwoGreysIsTheLuminanceTerm) {
    // No structure: (2 a b + C1) / (a^2 + b^2 + C1), exact values 1/4 and 1/2.
    const Picture a = constant(32, 20, {0.25f, 0.25f, 0.25f}), b = constant(32, 20, {0.5f, 0.5f, 0.5f});
    EXPECT_NEAR(ssim(a, b, {}), (0.25 + 1e-4) / (0.3125 + 1e-4), 1e-12);
    // A peak of 2 quadruples C1.
    EXPECT_NEAR(ssim(a, b, {.peak = 2}), (0.25 + 4e-4) / (0.3125 + 4e-4), 1e-12);
    // ffmpeg's C1 is 416 / 64^2 in squares of code values.
    const double c1 = 416.0 / 4096 / 65025;
    EXPECT_NEAR(ssim(a, b, kBoxes), (0.25 + c1) / (0.3125 + c1), 1e-12);
}

TEST(Ssim, OfANegativeIsNegative) {
    const Picture a = eight_bit_scene(60, 40, 1, 0.8f);
    const Picture b = picture_by(60, 40, [&](int x, int y) {
        const auto i = static_cast<std::size_t>(y * 60 + x);
        return glm::vec3(1 - a.rgb[0][i], 1 - a.rgb[1][i], 1 - a.rgb[2][i]);
    });
    EXPECT_LT(ssim(a, b, {}), -0.5);
    EXPECT_LT(ssim(a, b, kBoxes), -0.5);
}

TEST(Ssim, AgreesWithItsDefinition) {
    // 53 rows of windows lie in two tiles; widths that no vector divides.
    const Picture picture = eight_bit_scene(29, 63, 1, 0.3f), reference = eight_bit_scene(29, 63, 2, 0.2f);
    double total = 0;
    for (int top = 0; top <= 63 - 11; ++top) {
        for (int left = 0; left <= 29 - 11; ++left) total += window_ssim(picture, reference, left, top);
    }
    std::vector<float> map;
    // Variances as differences of squares lose a few of the double's digits.
    EXPECT_NEAR(ssim(picture, reference, {}, &map), total / (53 * 19), 1e-11);
    ASSERT_EQ(map.size(), 29u * 63);
    EXPECT_NEAR(map[29 * 5 + 5], window_ssim(picture, reference, 0, 0), 1e-7);
    EXPECT_NEAR(map[0], window_ssim(picture, reference, 0, 0), 1e-7);
    EXPECT_NEAR(map[29 * 40 + 12], window_ssim(picture, reference, 7, 35), 1e-7);
    EXPECT_NEAR(map[29 * 63 - 1], window_ssim(picture, reference, 18, 52), 1e-7);
}

TEST(Ssim, AgreesWithFfmpeg) {
    // ffmpeg prints six decimals and computes in float; sizes that neither 4 nor 8 divides.
    for (const float noise : {0.02f, 0.2f, 1.0f}) {
        const Picture picture = eight_bit_scene(203, 117, 1, noise);
        const Picture reference = eight_bit_scene(203, 117, 2, 0.5f * noise);
        EXPECT_NEAR(ssim(picture, reference, kBoxes), ffmpeg_figures(picture, reference).ssim, 3e-6) << noise;
    }
}

TEST(Ssim, AgreesWithFfmpegInTheDark) {
    // Values of 0 to 5 / 255, where its small C1 decides.
    Picture picture = eight_bit_scene(96, 64, 1, 1), reference = eight_bit_scene(96, 64, 2, 1);
    for (Picture* dark : {&picture, &reference}) {
        for (std::vector<float>& plane : dark->rgb) {
            for (float& value : plane) value = std::round(5 * value) / 255;
        }
    }
    EXPECT_NEAR(ssim(picture, reference, kBoxes), ffmpeg_figures(picture, reference).ssim, 3e-6);
}

TEST(Ssim, OfASmallPictureHasOneWindow) {
    const Picture a = constant(3, 2, {0.25f, 0.25f, 0.25f}), b = constant(3, 2, {0.5f, 0.5f, 0.5f});
    EXPECT_NEAR(ssim(a, b, {}), (0.25 + 1e-4) / (0.3125 + 1e-4), 1e-12);
    std::vector<float> map;
    EXPECT_GT(ssim(a, b, kBoxes, &map), 0.79);
    EXPECT_EQ(map.size(), 6u);
    EXPECT_EQ(ssim(constant(1, 1, {1, 1, 1}), constant(1, 1, {1, 1, 1}), kBoxes), 1);
}

TEST(Ssim, LeavesOutWindowsWithExcludedPixels) {
    // Pixels of columns 0 to 9 are bad, one of them is excluded in each row: windows that touch none of them
    // are those from column 10 on, as in the picture without these columns.
    Picture picture = eight_bit_scene(40, 24, 1, 0.3f), reference = eight_bit_scene(40, 24, 2, 0.2f);
    const auto right_part = [](const Picture& whole) {
        return picture_by(30, 24, [&](int x, int y) {
            const auto i = static_cast<std::size_t>(y * 40 + x + 10);
            return glm::vec3(whole.rgb[0][i], whole.rgb[1][i], whole.rgb[2][i]);
        });
    };
    const Picture picture_part = right_part(picture), reference_part = right_part(reference);
    for (std::uint32_t y = 0; y < 24; ++y) {
        exclude(picture, y * 40 + 9);
        exclude(reference, y * 40 + 9);
    }
    EXPECT_NEAR(ssim(picture, reference, {}), ssim(picture_part, reference_part, {}), 1e-12);
    // Boxes stand at multiples of 4; those at 0 and from 12 on are free of column 9.
    double boxes = 0;
    std::vector<float> map;
    const double without = ssim(picture, reference, kBoxes, &map);
    for (std::size_t row = 0; row < 5; ++row) {
        for (const std::size_t column : {0u, 3u, 4u, 5u, 6u, 7u, 8u}) {
            boxes += static_cast<double>(map[(4 * row + 4) * 40 + 4 * column + 4]);
        }
    }
    EXPECT_NEAR(without, boxes / 35, 1e-7);
}

TEST(Ssim, OfNothingIsOne) {
    Picture picture = constant(1, 1, {1, 1, 1});
    exclude(picture, 0);
    EXPECT_EQ(ssim(picture, picture, {}), 1);
}

}  // namespace
}  // namespace dapple::metrics
