#include "timeline/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/hash.h"

namespace dapple::timeline {
namespace {

Key key(double time, double value, Interpolation interpolation) {
    Key k;
    k.time = time;
    k.values = {value, 0, 0};
    k.interpolation = interpolation;
    return k;
}

/// Keys at uneven times with values of no pattern, some neighbours equal.
std::vector<Key> random_keys(std::uint64_t seed, Interpolation interpolation) {
    std::vector<Key> keys;
    double time = -0.7;
    for (std::uint64_t i = 0; i < 12; ++i) {
        const double value = i % 4 == 3 ? keys.back().values[0] : hash_uniform(seed, 0, i, 0) * 10 - 5;
        keys.push_back(key(time, value, interpolation));
        time += 0.01 + hash_uniform(seed, 0, i, 1);
    }
    return keys;
}

double at(const Curve& curve, double time) {
    return curve.at(time).front();
}

constexpr Interpolation kAll[] = {Interpolation::step, Interpolation::linear, Interpolation::cubic,
                                  Interpolation::bezier};

TEST(Curve, IsExactAtKeysAndHoldsOutside) {
    for (const Interpolation interpolation : kAll) {
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const std::vector<Key> keys = random_keys(seed, interpolation);
            const Curve curve(keys, 1);
            for (const Key& k : keys) EXPECT_EQ(at(curve, k.time), k.values[0]);
            EXPECT_EQ(at(curve, keys.front().time - 100), keys.front().values[0]);
            EXPECT_EQ(at(curve, keys.back().time + 100), keys.back().values[0]);
        }
    }
}

TEST(Curve, OneKeyIsAConstant) {
    const Curve curve({key(2, 0.1, Interpolation::cubic)}, 1);
    for (const double time : {-1.0, 2.0, 3.0}) EXPECT_EQ(at(curve, time), 0.1);
}

TEST(Curve, StepHoldsUpToTheNextKey) {
    const Curve curve({key(0, 1, Interpolation::step), key(1, 2, Interpolation::step)}, 1);
    EXPECT_EQ(at(curve, std::nextafter(1.0, 0.0)), 1);
    EXPECT_EQ(at(curve, 1), 2);
}

TEST(Curve, LinearIsALine) {
    Key begin = key(1, 2, Interpolation::linear);
    begin.values = {2, -4, 8};
    Key end = key(5, 0, Interpolation::linear);
    end.values = {4, 4, 0};
    const Values quarter = Curve({begin, end}, 3).at(2);
    EXPECT_EQ(quarter, (Values{2.5, -2, 6}));  // all exact in binary
}

TEST(Curve, CubicNeverOvershoots) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const std::vector<Key> keys = random_keys(seed, Interpolation::cubic);
        const Curve curve(keys, 1);
        for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
            const double a = keys[i].values[0];
            const double b = keys[i + 1].values[0];
            double last = a;
            for (int step = 0; step <= 100; ++step) {
                const double share = step / 100.0;
                const double value = at(curve, keys[i].time * (1 - share) + keys[i + 1].time * share);
                EXPECT_GE(value, std::min(a, b));
                EXPECT_LE(value, std::max(a, b));
                // Monotone to the rounding of values up to 5.
                EXPECT_GE((value - last) * (b >= a ? 1 : -1), -1e-14);
                last = value;
            }
        }
    }
}

TEST(Curve, CubicHasTheSlopesOfFritschAndButland) {
    // Secants 1 and 3 over equal widths: the slope between them is 6 / (3/1 + 3/3) = 1.5, that at the left
    // end (3 * 1 - 3) / 2 = 0. Halfway through the first segment: (0 + 1) / 2 + (0 - 1.5) / 8.
    const Interpolation cubic = Interpolation::cubic;
    const Curve curve({key(0, 0, cubic), key(1, 1, cubic), key(2, 4, cubic)}, 1);
    EXPECT_DOUBLE_EQ(at(curve, 0.5), 0.3125);
}

TEST(Curve, CubicIsSmoothAtKeys) {
    const std::vector<Key> keys = random_keys(3, Interpolation::cubic);
    const Curve curve(keys, 1);
    for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
        constexpr double kStep = 1e-7;
        const double before = (keys[i].values[0] - at(curve, keys[i].time - kStep)) / kStep;
        const double after = (at(curve, keys[i].time + kStep) - keys[i].values[0]) / kStep;
        // One-sided differences err by half the second derivative, below 6 |secant| / width <= 6e4, times the
        // step.
        EXPECT_NEAR(before, after, 1e-2);
    }
}

TEST(Curve, CubicOfALineIsTheLine) {
    std::vector<Key> keys;
    for (const double time : {0.0, 0.1, 1.0, 1.5, 4.0})
        keys.push_back(key(time, 3 * time - 1, Interpolation::cubic));
    const Curve curve(keys, 1);
    for (int i = 0; i <= 80; ++i)
        EXPECT_NEAR(at(curve, i * 0.05), 3 * (i * 0.05) - 1, 1e-14);  // a few ulp of 11
}

TEST(Curve, CubicLooksAtCubicNeighboursOnly) {
    const Interpolation cubic = Interpolation::cubic;
    const Curve after_step({key(-1, 50, Interpolation::step), key(0, 0, cubic), key(1, 1, cubic)}, 1);
    EXPECT_DOUBLE_EQ(at(after_step, 0.25), 0.25);  // alone a cubic segment is a line
}

Curve bezier(glm::dvec2 out, glm::dvec2 in) {
    Key begin = key(0, 0, Interpolation::bezier);
    begin.out = out;
    Key end = key(1, 1, Interpolation::bezier);
    end.in = in;
    return Curve({begin, end}, 1);
}

TEST(Curve, BezierAgreesWithClosedForms) {
    const Curve smooth = bezier({1.0 / 3, 0}, {2.0 / 3, 1});      // x = s: y = 3 s^2 - 2 s^3
    const Curve line = bezier({0.2, 0.2}, {0.9, 0.9});            // x = y whatever s
    const Curve cube_root = bezier({0, 1.0 / 3}, {0, 2.0 / 3});   // x = s^3, y = s
    const Curve from_right = bezier({1, 1.0 / 3}, {1, 2.0 / 3});  // x = 1 - (1 - s)^3, y = s
    for (int i = 1; i < 1000; ++i) {
        const double u = i / 1000.0;
        // x is met to a few ulp; where dx/ds goes to 0 as s^2 the error in s grows by 1 / (3 s^2) < 40 on
        // this grid.
        EXPECT_NEAR(at(smooth, u), u * u * (3 - 2 * u), 1e-14);
        EXPECT_NEAR(at(line, u), u, 1e-14);
        EXPECT_NEAR(at(cube_root, u), std::cbrt(u), 1e-13);
        EXPECT_NEAR(at(from_right, u), 1 - std::cbrt(1 - u), 1e-13);
    }
}

TEST(Curve, BezierStandsHandlesThatCross) {
    // x = 3 s (1 - s)^2 + s^3 stands still at s = 1/2, where Newton's steps have no slope.
    const Curve curve = bezier({1, 0}, {0, 1});
    double last = 0;
    for (int i = 0; i <= 1000; ++i) {
        const double value = at(curve, i / 1000.0);
        EXPECT_GE(value, last);
        EXPECT_LE(value, 1);
        last = value;
    }
    EXPECT_NEAR(at(curve, 0.5), 0.5, 1e-4);  // near the triple root s is known to the cube root of an ulp
}

}  // namespace
}  // namespace dapple::timeline
