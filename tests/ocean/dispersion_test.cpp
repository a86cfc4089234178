#include "ocean/dispersion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::ocean {
namespace {

// Tolerances of 1e-12 to 1e-14 are round-off of a handful of operations, unless a term left out is named.

TEST(Dispersion, DeepGravityWaves) {
    const double k = 0.1;  // 63 m; surface tension adds sigma k^2 / (2 g), 4e-8 of omega
    EXPECT_NEAR(angular_frequency(k, 1e4) / std::sqrt(kGravity * k), 1, 1e-7);
    EXPECT_NEAR(group_velocity(k, 1e4) / (0.5 * std::sqrt(kGravity / k)), 1, 2e-7);
}

TEST(Dispersion, ShallowWavesTravelAtOneSpeed) {
    const double depth = 0.01;
    const double k = 0.1;  // the next term of tanh is (k depth)^2 / 6, 2e-7
    const double speed = std::sqrt(kGravity * depth);
    EXPECT_NEAR(angular_frequency(k, depth) / (k * speed), 1, 2e-7);
    EXPECT_NEAR(group_velocity(k, depth) / speed, 1, 6e-7);
}

TEST(Dispersion, SlowestWaveOfDeepWater) {
    // The phase speed is least where gravity and tension are equal, and there equals the group velocity.
    const double k = std::sqrt(kGravity / kKinematicSurfaceTension);
    const double slowest = std::pow(4 * kGravity * kKinematicSurfaceTension, 0.25);
    EXPECT_NEAR(slowest, 0.232, 0.001);  // m/s, the figure for clean water
    EXPECT_NEAR(angular_frequency(k, 1e4) / k, slowest, 1e-14);
    EXPECT_NEAR(group_velocity(k, 1e4), slowest, 1e-14);
}

TEST(Dispersion, GroupVelocityIsTheDerivative) {
    for (const double depth : {0.1, 1.0, 30.0}) {
        for (const double k : {0.3, 4.0, 60.0}) {
            const double step = 1e-4 * k;  // error of the difference below: about (step / k)^2 = 1e-8
            const double difference =
                (angular_frequency(k + step, depth) - angular_frequency(k - step, depth)) / (2 * step);
            EXPECT_NEAR(group_velocity(k, depth) / difference, 1, 1e-7) << k << " " << depth;
        }
    }
}

}  // namespace
}  // namespace dapple::ocean
