#include "metrics/warping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

constexpr int kWidth = 64, kHeight = 48;

/// Something without symmetry, at any place.
glm::vec3 scene(double x, double y) {
    return {std::sin(0.31 * x + 0.2 * y), std::cos(0.17 * x * y / 20), std::sin(0.05 * x * x - 0.4 * y)};
}

/// The scene moved by (u, v) pixels since the frame before.
Picture moved(double u, double v) {
    return picture_by(kWidth, kHeight, [=](int x, int y) { return scene(x - u, y - v); });
}

Motion motion_by(const std::function<glm::vec2(int x, int y)>& value) {
    Motion motion{kWidth, kHeight, {}, {}};
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            motion.x.push_back(value(x, y).x);
            motion.y.push_back(value(x, y).y);
        }
    }
    return motion;
}

Motion uniform(float u, float v) {
    return motion_by([=](int, int) { return glm::vec2(u, v); });
}

TEST(Warping, OfATranslationByWholePixelsIsNone) {
    const WarpingError error = warping_error(moved(0, 0), moved(3, -2), uniform(-3, 2));
    EXPECT_EQ(error.mean_square, 0);
    EXPECT_EQ(error.visible_share, (kWidth - 3.0) * (kHeight - 2.0) / (kWidth * kHeight));
    const WarpingError still = warping_error(moved(0, 0), moved(0, 0), uniform(0, 0));
    EXPECT_EQ(still.mean_square, 0);
    EXPECT_EQ(still.visible_share, 1);
}

TEST(Warping, SeesMotionThatIsWrong) {
    for (const Motion& wrong :
         {uniform(3, 2), uniform(-3, -2), uniform(2, -3), uniform(0, 0), uniform(-2, 2)}) {
        EXPECT_GT(warping_error(moved(0, 0), moved(3, -2), wrong).mean_square, 1e-2);
    }
}

TEST(Warping, SamplesBetweenPixelsBilinearly) {
    // A bilinear picture is sampled exactly, but for rounding of floats up to 400, squared.
    const auto ramp = [](double u, double v) {
        return picture_by(kWidth, kHeight, [=](int x, int y) {
            const double a = x - u, b = y - v;
            return glm::vec3(a + 2 * b, a * b / 8, 3 * a);
        });
    };
    EXPECT_NEAR(warping_error(ramp(0, 0), ramp(0.5, 1.25), uniform(-0.5f, -1.25f)).mean_square, 0, 1e-9);
    EXPECT_GT(warping_error(ramp(0, 0), ramp(0.5, 1.25), uniform(-0.5f, -1.5f)).mean_square, 1e-2);
}

TEST(Warping, IsTheMeanSquareOfWhatChangesOnItsWay) {
    Picture frame = moved(1, 0);
    for (float& value : frame.rgb[0]) value += 0.5f;
    // 0.25 over three channels; values near 1 lose bits where 0.5 is added.
    EXPECT_NEAR(warping_error(moved(0, 0), frame, uniform(-1, 0)).mean_square, 0.25 / 3, 1e-7);
}

TEST(Warping, LeavesOutEdgesOfMotion) {
    // The right half stands still, the left half came from the left by 4 pixels.
    const Motion motion = motion_by([](int x, int) { return glm::vec2(x < kWidth / 2 ? -4.0f : 0.0f, 0); });
    const WarpingError error = warping_error(moved(0, 0), moved(0, 0), motion);
    // Without the first 4 columns, whose source is outside, and the two beside the edge.
    EXPECT_EQ(error.visible_share, (kWidth - 4.0 - 2) / kWidth);
    // A motion that changes slowly has none: 0.02 a pixel, (0.02)^2 < 0.002.
    const Motion zoom = motion_by([](int x, int) { return glm::vec2(-0.02f * static_cast<float>(x), 0); });
    EXPECT_EQ(warping_error(moved(0, 0), moved(0, 0), zoom).visible_share, 1);
}

TEST(Warping, LeavesOutExcludedPixelsAndTheirTargets) {
    Picture before = moved(0, 0), frame = moved(1, 0);
    Motion motion = uniform(-1, 0);
    const auto pixel = [](int x, int y) { return static_cast<std::uint32_t>(y * kWidth + x); };
    exclude(before, pixel(10, 10));
    exclude(frame, pixel(30, 20));
    WarpingError error = warping_error(before, frame, motion);
    EXPECT_EQ(error.mean_square, 0);
    EXPECT_DOUBLE_EQ(error.visible_share, ((kWidth - 1.0) * kHeight - 2) / (kWidth * kHeight));
    // Half a pixel on, its square is the weight of two pixels.
    error = warping_error(before, frame, uniform(-0.5f, 0));
    EXPECT_DOUBLE_EQ(error.visible_share, ((kWidth - 1.0) * kHeight - 3) / (kWidth * kHeight));

    motion.x[pixel(40, 20)] = std::numeric_limits<float>::quiet_NaN();
    error = warping_error(moved(0, 0), moved(1, 0), motion);
    EXPECT_EQ(error.mean_square, 0);
    // It and the four that look at it for edges.
    EXPECT_DOUBLE_EQ(error.visible_share, ((kWidth - 1.0) * kHeight - 5) / (kWidth * kHeight));
    EXPECT_EQ(warping_error(before, frame, uniform(-1000, 0)).visible_share, 0);
}

}  // namespace
}  // namespace dapple::metrics
