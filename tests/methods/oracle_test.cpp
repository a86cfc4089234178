// Proven paths against closed forms and one-dimensional root finding.
#include "methods/reference/oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "methods/oracle_scenes.h"

namespace dapple::oracle {
namespace {

using test::random_between;

constexpr glm::dvec3 kUp{0, 1, 0};

/// 1 - F of unpolarised light from the air, by Fresnel's sine and tangent forms.
long double transmitted_share(long double incident, long double refracted) {
    if (incident == 0) {
        const long double n = 1.333L;
        return 1 - (n - 1) * (n - 1) / ((n + 1) * (n + 1));
    }
    const long double s = std::sin(incident - refracted) / std::sin(incident + refracted);
    const long double p = std::tan(incident - refracted) / std::tan(incident + refracted);
    return 1 - 0.5L * (s * s + p * p);
}

long double refraction_angle(long double incident) {
    return std::asin(std::sin(incident) / 1.333L);
}

scene::Water flat_water() {
    scene::Water water;
    water.extent.size = {40, 40};
    return water;
}

class FlatWater : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Elevations, FlatWater, testing::Values(90, 60, 30, 10),
                         [](const auto& elevation) { return std::to_string(int(elevation.param)); });

TEST_P(FlatWater, SunHasOnePathOfTheClosedForm) {
    const double depth = 2.5;
    const Oracle oracle(flat_water(), test::sun_at(GetParam(), 30), 0);
    const long double i = (90 - GetParam()) * scene::kDegree, t = refraction_angle(i);
    const double floor = static_cast<double>(std::cos(i) * transmitted_share(i, t));
    const Result level = oracle.paths({1, -depth, -2}, kUp);
    ASSERT_EQ(level.paths.size(), 1u);
    EXPECT_TRUE(level.proven);
    EXPECT_FALSE(level.paths[0].blocked);
    EXPECT_EQ(level.sign(), 1);
    // A score of roundings, and at 80 degrees 1 - F loses a digit here.
    EXPECT_NEAR(level.irradiance(), floor, 1e-14);
    EXPECT_NEAR(level.paths[0].jacobian, 1, 1e-15);
    EXPECT_NEAR(level.paths[0].way, depth / static_cast<double>(std::cos(t)), 1e-14);
    EXPECT_NEAR(level.paths[0].water_point.y, 0, 1e-300);

    // A tilted receiver: the flux across the ray, turned.
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, 0.8, -0.5));
    const Result tilted = oracle.paths({1, -depth, -2}, normal);
    const double cosine = std::max(0.0, -glm::dot(tilted.paths[0].direction, normal));
    EXPECT_NEAR(tilted.irradiance(), floor / static_cast<double>(std::cos(t)) * cosine, 1e-14);
    // From behind nothing arrives, but the path is there.
    const Result turned = oracle.paths({1, -depth, -2}, -kUp);
    EXPECT_EQ(turned.paths.size(), 1u);
    EXPECT_EQ(turned.irradiance(), 0);
}

TEST(FlatWater, LampHasOnePathOfTheClosedForm) {
    // r = a tan i + b tan t, E = (1 - F) sin i / (r dr/di), for 1 W/sr.
    const double a = 1.7, b = 2.2;
    const Oracle oracle(flat_water(), test::lamp_at({3, a, -1}), 0);
    for (const double r : {0.01, 0.3, 1.0, 4.0, 9.0}) {
        long double low = 0, high = 1.57L;
        for (int step = 0; step < 80; ++step) {
            const long double i = 0.5L * (low + high);
            (a * std::tan(i) + b * std::tan(refraction_angle(i)) < r ? low : high) = i;
        }
        const long double i = low, t = refraction_angle(i);
        const long double slope =
            a / std::pow(std::cos(i), 2) + b * std::cos(i) / (1.333L * std::pow(std::cos(t), 3));
        const double expected = static_cast<double>(transmitted_share(i, t) * std::sin(i) / (r * slope));
        const Result result = oracle.paths({3 + r * std::cos(0.4), -b, -1 + r * std::sin(0.4)}, kUp);
        ASSERT_EQ(result.paths.size(), 1u) << r;
        EXPECT_TRUE(result.proven);
        EXPECT_EQ(result.sign(), 1);
        EXPECT_NEAR(result.irradiance() / expected, 1, 1e-12) << r;
        EXPECT_NEAR(result.paths[0].way, b / static_cast<double>(std::cos(t)), 1e-12);
    }
    const Result on_axis = oracle.paths({3, -b, -1}, kUp);
    const double expected = static_cast<double>(transmitted_share(0, 0)) / std::pow(a + b / 1.333, 2);
    EXPECT_NEAR(on_axis.irradiance() / expected, 1, 1e-13);
}

TEST(FlatWater, SpotFallsOffBetweenItsCones) {
    scene::Light spot = test::lamp_at({0, 2, 0});
    spot.type = scene::LightType::spot;
    const Oracle lamp(flat_water(), test::lamp_at({0, 2, 0}), 0), oracle(flat_water(), spot, 0);
    const auto share = [&](double angle_degrees) {  // at a point just below the water
        const glm::dvec3 point(2 * std::tan(angle_degrees * scene::kDegree), -1e-9, 0);
        return oracle.paths(point, kUp).irradiance() / lamp.paths(point, kUp).irradiance();
    };
    // Full inside 25 degrees, nothing outside 30, half where the cosine is half-way.
    EXPECT_NEAR(share(24.9), 1, 1e-14);
    EXPECT_EQ(share(30.1), 0);
    const double half = std::acos(0.5 * (std::cos(25 * scene::kDegree) + std::cos(30 * scene::kDegree)));
    EXPECT_NEAR(share(half / scene::kDegree), 0.5, 1e-7);  // the point is 1e-9 m below the water
}

TEST(FlatWater, PartOfAnAreaLightShinesByTheCosineToOneSide) {
    scene::Light part = test::lamp_at({0, 2, 0});
    part.type = scene::LightType::quad;
    part.direction = {std::sin(0.5), -std::cos(0.5), 0};  // leans to +x
    const Oracle lamp(flat_water(), test::lamp_at({0, 2, 0}), 0), oracle(flat_water(), part, 0);
    for (const double angle : {-1.2, -1.0, -0.3, 0.4, 1.3}) {  // a point just below the water
        const glm::dvec3 point(2 * std::tan(angle), -1e-9, 0);
        const Result lit = oracle.paths(point, kUp);
        ASSERT_EQ(lit.paths.size(), 1u);
        const double cosine = std::max(0.0, std::cos(angle - 0.5));
        EXPECT_NEAR(lit.irradiance() / lamp.paths(point, kUp).irradiance(), cosine, 1e-7);
        EXPECT_NEAR(lit.paths[0].sent, cosine, 1e-7);
        EXPECT_EQ(lit.paths[0].sent == 0, angle == -1.2) << "the plane of the part is at -1.07";
    }
}

TEST(FlatWater, MirrorsALampBelowItself) {
    // The image lamp at height -a lights the ceiling: E = F cos / R^2.
    const double a = 1.5, ceiling = 2, r = 1.2;
    const Oracle oracle(flat_water(), test::lamp_at({0, a, 0}), 0, Event::reflection);
    const Result result = oracle.paths({r, ceiling, 0}, -kUp);
    ASSERT_EQ(result.paths.size(), 1u);
    EXPECT_TRUE(result.proven);
    const long double i = std::atan2(r, a + ceiling), t = refraction_angle(i);
    const double distance = std::hypot(r, a + ceiling);
    const double expected =
        static_cast<double>((1 - transmitted_share(i, t)) * std::cos(i)) / (distance * distance);
    EXPECT_NEAR(result.irradiance() / expected, 1, 1e-12);
    EXPECT_EQ(result.paths[0].way, 0);
    EXPECT_EQ(oracle.paths({r, ceiling, 0}, kUp).irradiance(), 0);
}

TEST(FlatWater, EndsAtItsEdges) {
    scene::Water water = flat_water();
    water.extent.size = {2, 2};
    const Oracle oracle(water, test::sun_at(50, 20), 0);
    const auto below = [&](double x) {  // the point that the ray through (x, 0.3) lights
        const glm::dvec2 at = oracle.land({x, 0.3}, -1).position;
        return oracle.paths({at.x, -1, at.y}, kUp);
    };
    EXPECT_EQ(below(1 - 1e-6).paths.size(), 1u);
    const Result outside = below(1 + 1e-6);
    EXPECT_TRUE(outside.paths.empty() && outside.proven);
    const Result edge = below(1);  // within rounding
    EXPECT_FALSE(edge.proven);
    ASSERT_FALSE(edge.undecided.empty());
    EXPECT_NEAR(edge.undecided[0].center.x, 1, 1e-10);
}

TEST(Oracle, KnowsWhereLightCanStand) {
    EXPECT_TRUE(Oracle(flat_water(), test::sun_at(-5), 0).paths({0, -1, 0}, kUp).paths.empty());
    EXPECT_THROW(Oracle(flat_water(), test::lamp_at({0, -0.5, 0}), 0), Error);
    // Transmitted light does not come to a point in the air: the way there leaves the water.
    const Oracle oracle(test::one_sinusoid(0.5, 0.05), test::sun_at(90), 0);
    for (const Path& path : oracle.paths({0.25, -0.04, 0}, kUp).paths) EXPECT_TRUE(path.blocked);
}

// ---- one sinusoid under an overhead sun -------------------------------------------------------------------

constexpr double kLength = 0.5;
const long double kWaveNumber = 2 * std::numbers::pi / kLength;

struct Ray {
    long double landing, slope, transmittance;  ///< X, dX/dx, T
};
/// Refracted at a cos kx: with tilt alpha and refracted angle beta from the normal, X = x + (y + h) tan(alpha
/// - beta).
Ray refracted_ray(long double x, long double amplitude, long double depth) {
    const long double k = kWaveNumber, height = amplitude * std::cos(k * x);
    const long double first = -amplitude * k * std::sin(k * x), second = -k * k * height;
    const long double alpha = std::atan(first), beta = refraction_angle(alpha), turn = std::tan(alpha - beta);
    const long double turn_rate =
        second / (1 + first * first) * (1 - std::cos(alpha) / (1.333L * std::cos(beta)));
    return {x + (depth + height) * turn, 1 + first * turn + (depth + height) * (1 + turn * turn) * turn_rate,
            transmitted_share(std::abs(alpha), std::abs(beta))};
}

/// All x with X(x) = target, from sign changes on a fine grid and bisection to the last bit; empty if a fold
/// is so near that the grid could miss a pair.
std::vector<long double> sinusoid_paths(long double target, long double amplitude, long double depth) {
    constexpr int kCells = 8000;
    constexpr long double kReach = 4;
    std::vector<long double> roots;
    const auto f = [&](long double x) { return refracted_ray(x, amplitude, depth).landing - target; };
    long double left = f(-kReach);
    for (int c = 0; c < kCells; ++c) {
        long double low = kReach * (2.0L * c / kCells - 1), high = kReach * (2.0L * (c + 1) / kCells - 1);
        const long double right = f(high);
        const bool rising = left < 0;
        if (rising != (right < 0)) {
            for (int step = 0; step < 70; ++step) {
                const long double middle = 0.5L * (low + high);
                ((f(middle) < 0) == rising ? low : high) = middle;
            }
            roots.push_back(low);
        }
        left = right;
    }
    return roots;
}

TEST(Sinusoid, PathsAreThoseOfOneDimensionalRootFinding) {
    // kappa = depth / focal depth; the paraxial focus of 1 cm is at 2.54 m.
    const double amplitude = 0.01;
    const double focus = 1.333 / (0.333 * amplitude * std::pow(static_cast<double>(kWaveNumber), 2));
    const Oracle oracle(test::one_sinusoid(kLength, amplitude), test::sun_at(90), 0);
    std::vector<std::size_t> seen;
    for (const double kappa : {0.5, 0.9, 1.5, 3.0, 6.0, 10.0}) {
        std::size_t fewest = 100, most = 0;
        for (std::uint64_t i = 0; i < 40; ++i) {
            const double x = random_between(-kLength, kLength, i, 0), depth = kappa * focus;
            const std::vector<long double> expected = sinusoid_paths(x, amplitude, depth);
            Result result = oracle.paths({x, -depth, 0.25}, kUp);
            ASSERT_TRUE(result.proven);
            ASSERT_EQ(result.paths.size(), expected.size()) << kappa << ' ' << x;
            EXPECT_EQ(result.sign(), 1);
            std::ranges::sort(result.paths, {}, [](const Path& path) { return path.water_point.x; });
            for (std::size_t p = 0; p < expected.size(); ++p) {
                const Ray ray = refracted_ray(expected[p], amplitude, depth);
                const Path& path = result.paths[p];
                // A landing point is off by some 1e-15 m times the depth, the source by that over the slope.
                const double off = 1e-14 * (1 + depth) / static_cast<double>(std::abs(ray.slope));
                EXPECT_NEAR(path.water_point.x, static_cast<double>(expected[p]), std::max(off, 1e-15));
                EXPECT_NEAR(path.water_point.z, 0.25, 1e-15);
                const double relative = 1e-12 + 300 * depth * off / static_cast<double>(std::abs(ray.slope));
                EXPECT_NEAR(path.jacobian / static_cast<double>(ray.slope), 1, relative);
                EXPECT_NEAR(path.irradiance * static_cast<double>(std::abs(ray.slope) / ray.transmittance), 1,
                            relative);
            }
            fewest = std::min(fewest, expected.size());
            most = std::max(most, expected.size());
        }
        seen.push_back(fewest);
        seen.push_back(most);
    }
    // 1 before the focus; behind it fold pairs half sqrt(kappa^2 - 1) - arccos(1 / kappa) wide in kX, each a
    // period from the next: 1.58 at 3, 4.51 at 6 and 8.48 at 10 cover a point at most 1, 2 and 3 times, and
    // at least 0, 1 and 2 times.
    EXPECT_EQ(seen, (std::vector<std::size_t>{1, 1, 1, 1, 1, 3, 1, 3, 3, 5, 5, 7}));
}

TEST(Sinusoid, PointsOnAFoldAreLeftUndecided) {
    const double amplitude = 0.01, depth = 4;
    long double low = 0, high = 0.1;  // dX/dx changes its sign between crest and quarter wave
    for (int step = 0; step < 70; ++step) {
        const long double middle = 0.5L * (low + high);
        (refracted_ray(middle, amplitude, depth).slope < 0 ? low : high) = middle;
    }
    const Oracle oracle(test::one_sinusoid(kLength, amplitude), test::sun_at(90), 0);
    const auto fold = static_cast<double>(refracted_ray(low, amplitude, depth).landing);
    const Result on_fold = oracle.paths({fold, -depth, 0}, kUp);
    EXPECT_FALSE(on_fold.proven);
    EXPECT_EQ(on_fold.paths.size(), 1u);  // the other sheet's
    ASSERT_FALSE(on_fold.undecided.empty());
    // Landing points differ by X'' dx^2 / 2 there, which vanishes in rounding, 1e-15, below some 1e-8 m.
    for (const UndecidedBox& box : on_fold.undecided) {
        EXPECT_NEAR(box.center.x, static_cast<double>(low), 3e-8);
        EXPECT_LT(box.half_size.x, 3e-8);
    }
    EXPECT_LE(on_fold.undecided.size(), 3u);  // neighbours are merged
    // A nanometre to either side it is certain again: there the pair is some 1e-5 m apart.
    const Result inside = oracle.paths({fold + 1e-9, -depth, 0}, kUp);
    const Result outside = oracle.paths({fold - 1e-9, -depth, 0}, kUp);
    EXPECT_TRUE(inside.proven && outside.proven);
    EXPECT_EQ(inside.paths.size() + outside.paths.size(), 4u);
    EXPECT_EQ(inside.sign(), 1);
    EXPECT_EQ(outside.sign(), 1);
}

TEST(Sinusoid, PathsOnTheBorderOfBoxesCountOnce) {
    // Everything is symmetric about x = 0, where boxes are split and the light passes straight down.
    const double amplitude = 0.01, depth = 4;
    const Oracle oracle(test::one_sinusoid(kLength, amplitude), test::sun_at(90), 0);
    const Result result = oracle.paths({0, -depth, 0}, kUp);
    EXPECT_TRUE(result.proven);
    EXPECT_EQ(result.paths.size(), sinusoid_paths(1e-9L, amplitude, depth).size());
    EXPECT_EQ(std::ranges::count_if(result.paths,
                                    [](const Path& path) { return std::abs(path.water_point.x) < 1e-15; }),
              1);
    EXPECT_EQ(result.sign(), 1);
}

TEST(Sinusoid, WavesShadowEachOtherUnderALowSun) {
    // Clearances of the ray to the sun and of the ray in the water, by dense sampling.
    const double amplitude = 0.04, k = 2 * std::numbers::pi / kLength;
    const auto height = [&](double x) { return amplitude * std::cos(k * x); };
    const scene::Light sun = test::sun_at(12);
    const Oracle oracle(test::one_sinusoid(kLength, amplitude), sun, 0);
    int blocked = 0, clear = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
        const Result result =
            oracle.paths({random_between(-kLength, kLength, i, 0), -random_between(0.05, 1, i, 1), 0}, kUp);
        ASSERT_TRUE(result.proven);
        for (const Path& path : result.paths) {
            double least = 1;
            for (int s = 1; s < 4000; ++s) {
                const glm::dvec3 up = path.water_point - (s * 2e-4) * sun.direction;
                least = std::min(least, up.y - height(up.x));
                const glm::dvec3 down = path.water_point + (s / 4000.0 * path.way) * path.direction;
                least = std::min(least, height(down.x) - down.y);
            }
            EXPECT_EQ(path.blocked, least < 0) << least;
            EXPECT_GT(path.irradiance, 0);  // facets that face away from the light are no paths
            (path.blocked ? blocked : clear) += 1;
        }
    }
    EXPECT_GT(blocked, 10);
    EXPECT_GT(clear, 10);
}

}  // namespace
}  // namespace dapple::oracle
