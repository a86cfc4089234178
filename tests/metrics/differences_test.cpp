#include "metrics/differences.h"

#include <gtest/gtest.h>

#include <cmath>

#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

Picture still(int t) {
    return picture_by(21, 8, [t](int x, int y) {
        const float value = static_cast<float>((3 * x + y + t) % 16) / 16;
        return glm::vec3(value, value / 2, 1 - value);
    });
}

Picture brighter(Picture picture, glm::vec3 more) {
    for (int c = 0; c < 3; ++c) {
        for (float& value : picture.rgb[static_cast<std::size_t>(c)]) value += more[c];
    }
    return picture;
}

TEST(TemporalDifference, IsNoneWhereBothChangeAlike) {
    // Both move, and the picture is off by a constant.
    const glm::vec3 bias(0.25f, 0.5f, -0.25f);
    const auto same =
        temporal_difference(brighter(still(0), bias), brighter(still(1), bias), still(0), still(1));
    EXPECT_EQ(same.mae, 0);
    EXPECT_EQ(same.rmse, 0);
}

TEST(TemporalDifference, IsTheChangeThatTheReferenceLacks) {
    const auto flash =
        temporal_difference(still(0), brighter(still(1), {0.25f, 0.5f, -0.25f}), still(0), still(1));
    EXPECT_NEAR(flash.mae, 1.0 / 3, 1e-14);
    EXPECT_NEAR(flash.rmse, std::sqrt(0.125), 1e-14);
    // It sees a flash where it begins and where it ends, by the same amount.
    const auto end =
        temporal_difference(brighter(still(1), {0.25f, 0.5f, -0.25f}), still(2), still(1), still(2));
    EXPECT_EQ(end.mae, flash.mae);
}

TEST(TemporalDifference, LeavesOutExcludedPixels) {
    Picture before = still(0), frame = brighter(still(1), glm::vec3(0.5f));
    const Picture reference_before = still(0), reference = still(1);
    frame.rgb[1][5] = frame.rgb[1][17] = 100;
    exclude(before, 5);
    Picture reference_with_hole = reference;
    exclude(reference_with_hole, 17);
    const auto figures = temporal_difference(before, frame, reference_before, reference_with_hole);
    EXPECT_NEAR(figures.mae, 0.5, 1e-14);
    EXPECT_NEAR(figures.rmse, 0.5, 1e-14);
}

TEST(DeltaFlip, IsTheSignedAndTheAbsoluteMean) {
    const std::vector<float> map = {0.5f, 0.25f, 0.75f, 0.5f}, reference = {0.25f, 0.5f, 0.25f, 0.5f};
    EXPECT_EQ(delta_flip(map, reference).mean, 0.125);
    EXPECT_EQ(delta_flip(map, reference).mean_absolute, 0.25);
    EXPECT_EQ(delta_flip(map, reference, {1}).mean, 0.25);
    EXPECT_EQ(delta_flip(map, map).mean_absolute, 0);
    EXPECT_EQ(delta_flip({0.5f}, {0.25f}, {0}).mean, 0);
}

}  // namespace
}  // namespace dapple::metrics
