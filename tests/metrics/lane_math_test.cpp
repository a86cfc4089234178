#include "metrics/lane_math.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::metrics {
namespace {

constexpr double kError = 1e-6;  // what the header states

float first(Floats lanes) {
    return lanes[0];
}

/// Largest relative error of `ours` to `right` over [low, high], in equal ratios.
template <typename Ours, typename Right>
double error(double low, double high, const Ours& ours, const Right& right) {
    constexpr int kSteps = 200000;
    double worst = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const auto x = static_cast<float>(low * std::pow(high / low, static_cast<double>(i) / kSteps));
        const double exact = right(static_cast<double>(x));
        worst = std::fmax(worst, std::abs(static_cast<double>(first(ours(all(x)))) / exact - 1));
    }
    return worst;
}

TEST(LaneMath, CubeRoot) {
    EXPECT_LT(error(
                  1e-6, 1e6, [](Floats x) { return cube_root(x); }, [](double x) { return std::cbrt(x); }),
              kError);
    EXPECT_NEAR(first(cube_root(all(1))), 1, 2e-7);
}

TEST(LaneMath, PowersOfFlip) {
    const auto power_error = [](double low, double high, float y) {
        return error(
            low, high, [y](Floats x) { return power(x, all(y)); },
            [y](double x) { return std::pow(x, static_cast<double>(y)); });
    };
    EXPECT_LT(power_error(0.09, 1, 2.4f), kError);    // sRGB
    EXPECT_LT(power_error(1e-4, 400, 0.7f), kError);  // HyAB
    for (const float y : {0.01f, 0.1f, 0.5f, 0.9f, 1.0f}) {
        EXPECT_LT(power_error(1e-4, 1, y), kError) << y;
        EXPECT_LT(power_error(1e-8, 1, y), 2 * kError) << y;
    }
}

TEST(LaneMath, PowersAtTheEnds) {
    EXPECT_EQ(first(power(all(0), all(0.7f))), 0);
    EXPECT_EQ(first(power(all(0), all(1))), 0);
    EXPECT_EQ(first(power(all(1), all(0.3f))), 1);
    EXPECT_NEAR(first(power(all(0.25f), all(0))), 1, kError);
    // A denormal number does not become what another's bits would mean.
    EXPECT_LT(first(power(all(1e-40f), all(1))), 1e-37f);
}

TEST(LaneMath, LogarithmAndExponential) {
    EXPECT_EQ(first(log2_of(all(8))), 3);
    EXPECT_EQ(first(exp2_of(all(-3))), 0.125f);
    EXPECT_EQ(first(log2_of(all(1))), 0);
}

}  // namespace
}  // namespace dapple::metrics
