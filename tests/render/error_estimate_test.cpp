#include "render/error_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::render {
namespace {

TEST(RelativeDifference, IsOfPixelsThatBothCover) {
    const PixelIrradiance a{{{1, 2, 3}, {4, 4, 4}, {9, 9, 9}}, {1, 1, 0}};
    const PixelIrradiance b{{{2, 2, 2}, {4, 6, 4}, {1, 1, 1}}, {1, 1, 1}};
    EXPECT_DOUBLE_EQ(relative_difference(a, b), 4.0 / 20);
    const PixelIrradiance dark{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {1, 1, 1}};
    EXPECT_EQ(relative_difference(dark, dark), 0);
}

/// Distances of three resolutions whose errors are e, e r, e r^2, of correlation c.
Convergence of_model(double e, double r, double c) {
    const auto apart = [&](double a, double b) { return std::sqrt(a * a + b * b - 2 * c * a * b); };
    return convergence(apart(e, e * r), apart(e * r, e * r * r), apart(e, e * r * r));
}

TEST(Convergence, FindsTheErrorWhateverOfItIsNoiseAndWhateverBlur) {
    for (const double ratio : {0.25, 0.5, 0.7}) {
        for (const double correlation : {0.0, 0.5, 1.0}) {
            const Convergence found = of_model(0.08, ratio, correlation);
            EXPECT_NEAR(found.error, 0.08, 1e-9) << ratio << " " << correlation;
            EXPECT_NEAR(found.ratio, ratio, 1e-9);
        }
    }
}

TEST(Convergence, KeepsToTheTriangle) {
    // The first differs from the last by less than from the second: no three such errors are alike.
    const Convergence low = convergence(0.1, 0.05, 0.01);
    EXPECT_DOUBLE_EQ(low.error, 0.01 / 1.25);
    const Convergence high = convergence(0.01, 0.005, 0.1);
    EXPECT_DOUBLE_EQ(high.error, 0.1 / 0.75);
}

TEST(Convergence, OfWhatDoesNotConvergeIsUnknown) {
    EXPECT_TRUE(std::isinf(convergence(0.1, 0.1, 0.1).error));
    EXPECT_TRUE(std::isinf(convergence(0.1, 0.2, 0.2).error));
    EXPECT_EQ(convergence(0, 0, 0).error, 0);  // light that every map finds alike
}

TEST(ErrorCurve, FollowsPowerLaws) {
    ErrorCurve curve;
    EXPECT_TRUE(std::isinf(curve.resolution_for(0.1)));
    curve.add(64, HUGE_VAL);
    curve.add(128, 0.16);
    curve.add(256, 0.08);
    curve.add(512, 0.02);
    EXPECT_DOUBLE_EQ(curve.at(128), 0.16);
    EXPECT_NEAR(curve.at(128 * std::sqrt(2.0)), 0.16 / std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(curve.at(1024), 0.005, 1e-12);
    EXPECT_TRUE(std::isinf(curve.at(100)));
    EXPECT_NEAR(curve.resolution_for(0.04), 256 * std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(curve.resolution_for(0.005), 1024, 1e-9);
    EXPECT_EQ(curve.resolution_for(0.5), 128);  // nothing is known below
}

TEST(ErrorCurve, IsNotFooledByAnErrorThatRisesAgain) {
    ErrorCurve curve;
    curve.add(64, 0.05);
    curve.add(128, 0.2);
    curve.add(256, 0.1);
    EXPECT_GT(curve.resolution_for(0.06), 256);
    EXPECT_NEAR(curve.resolution_for(0.15), 128 * std::pow(0.2 / 0.15, 1.0), 1e-9);
}

TEST(ErrorCurve, OfWhatDoesNotFallEndsNowhere) {
    ErrorCurve curve;
    curve.add(64, 0.1);
    curve.add(128, 0.1);
    EXPECT_TRUE(std::isinf(curve.resolution_for(0.05)));
    EXPECT_EQ(curve.resolution_for(0.1), 64);
}

}  // namespace
}  // namespace dapple::render
