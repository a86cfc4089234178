// The parts that the oracle's proofs rest on: interval arithmetic, bounds of the surface, the landing map.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "methods/oracle_scenes.h"
#include "methods/reference/interval.h"
#include "methods/reference/oracle.h"
#include "ocean/dispersion.h"
#include "ocean/water_surface.h"

namespace dapple::oracle {
namespace {

using test::random_between;

/// Both signs, sizes from 1e-9 to 1e9; every third interval is a single number.
Interval random_interval(std::uint64_t index, std::uint32_t dimension) {
    const auto number = [&](std::uint32_t d) {
        const double size = std::pow(10.0, random_between(-9, 9, index, dimension + d));
        return random_between(-1, 1, index, dimension + d + 1) < 0 ? -size : size;
    };
    const double a = number(0), b = index % 3 == 0 ? a : number(2);
    return {std::min(a, b), std::max(a, b)};
}

/// Both ends and three numbers inside.
std::vector<long double> members(Interval interval) {
    std::vector<long double> numbers;
    for (int i = 0; i <= 4; ++i) {
        const long double share = static_cast<long double>(i) / 4;
        numbers.push_back(i == 4
                              ? interval.hi
                              : interval.lo + share * (static_cast<long double>(interval.hi) - interval.lo));
    }
    return numbers;
}

// 11 bits more than a double: enough to tell that an end has been rounded inwards.
bool holds(Interval interval, long double x) {
    return interval.lo <= x && x <= interval.hi;
}

TEST(Interval, HoldsEveryResultOfItsMembers) {
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const Interval a = random_interval(i, 0), b = random_interval(i, 10);
        const double c = random_interval(3 * i, 20).lo;
        for (const long double x : members(a)) {
            ASSERT_TRUE(holds(-a, -x));
            ASSERT_TRUE(holds(square(a), x * x)) << i;
            ASSERT_TRUE(x < 0 || holds(square_root(a), std::sqrt(x))) << i;
            ASSERT_TRUE(holds(a + c, x + c) && holds(a - c, x - c) && holds(c - a, c - x) &&
                        holds(c * a, c * x))
                << i;
            for (const long double y : members(b)) {
                ASSERT_TRUE(holds(a + b, x + y) && holds(a - b, x - y) && holds(a * b, x * y)) << i;
                ASSERT_TRUE(contains(b, 0.0) || holds(a / b, x / y)) << i;
            }
        }
    }
}

TEST(Interval, IsTightAroundSingleNumbers) {
    for (std::uint64_t i = 0; i < 3000; i += 3) {
        const Interval a = random_interval(i, 0), b = random_interval(i, 10);
        // At most 2 units in the last place on either side.
        for (const Interval c : {a * b, a / b, a + b, square(a)})
            ASSERT_LE(width(c), 4 * 0x1p-52 * std::max(std::abs(c.lo), std::abs(c.hi)) + 1e-300);
    }
}

TEST(Interval, OverlapsAsSetsDo) {
    const Interval a = {0, 2}, b = {1, 3}, c = {2, 4};
    EXPECT_FALSE(disjoint(a, c));  // ends belong to it
    EXPECT_TRUE(disjoint(a, Interval{2.5, 3}));
    EXPECT_EQ(intersection(a, b).lo, 1);
    EXPECT_EQ(intersection(a, b).hi, 2);
    EXPECT_TRUE(contains(a, Interval{0, 1}));
    EXPECT_FALSE(contains_in_interior(a, Interval{0, 1}));
    EXPECT_TRUE(contains_in_interior(a, Interval{0.5, 1}));
}

/// The jet written down anew, in 64 bits.
Jet<long double> exact_jet(const scene::Water& water, double time, long double x, long double z) {
    Jet<long double> jet;
    for (const scene::Wave& wave : water.surface.waves.waves) {
        const double k = 2 * std::numbers::pi / wave.length;
        const double omega = ocean::angular_frequency(k, water.surface.waves.depth);
        const long double kx = k * std::cos(wave.heading), kz = k * std::sin(wave.heading);
        const long double phase = kx * x + kz * z - static_cast<long double>(omega) * time + wave.phase;
        const long double c = wave.amplitude * std::cos(phase), s = wave.amplitude * std::sin(phase);
        jet.height += c;
        jet.x -= kx * s;
        jet.z -= kz * s;
        jet.xx -= kx * kx * c;
        jet.xz -= kx * kz * c;
        jet.zz -= kz * kz * c;
    }
    return jet;
}

bool holds(const Jet<Interval>& bounds, const Jet<long double>& jet) {
    return holds(bounds.height, jet.height) && holds(bounds.x, jet.x) && holds(bounds.z, jet.z) &&
           holds(bounds.xx, jet.xx) && holds(bounds.xz, jet.xz) && holds(bounds.zz, jet.zz);
}

TEST(OracleSurface, BoundsHoldTheJetInTheBox) {
    constexpr double time = 12.5;
    const scene::Water water = test::sea_of_24_waves(3);
    const Surface surface(water, time);
    int too_large = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
        const glm::dvec2 anchor(random_between(-300, 300, i, 0), random_between(-300, 300, i, 1));
        const Surface::Local local(surface, anchor);
        const double x = random_between(-3, 3, i, 2), z = random_between(-3, 3, i, 3);
        const double radius_x = std::pow(10.0, random_between(-12, 0.5, i, 4)), radius_z = 0.4 * radius_x;
        Jet<Interval> middle, over;
        const bool fine = local.bounds(x, z, radius_x, radius_z, middle, over);
        too_large += fine ? 0 : 1;
        const auto at = [&](double dx, double dz) {
            return exact_jet(water, time,
                             static_cast<long double>(anchor.x) + x + static_cast<long double>(dx),
                             static_cast<long double>(anchor.y) + z + static_cast<long double>(dz));
        };
        if (fine) {
            ASSERT_TRUE(holds(middle, at(0, 0))) << i;
            ASSERT_LT(width(middle.zz), 1e-10);  // 24 waves of at most 6 /m, and 1e5 rad reduced to 1e-13
        }
        for (std::uint32_t s = 0; s < 30; ++s) {
            double dx = radius_x * random_between(-1, 1, i, 10 + 2 * s);
            double dz = radius_z * random_between(-1, 1, i, 11 + 2 * s);
            if (s < 4) {
                dx = s % 2 == 0 ? radius_x : -radius_x;
                dz = s < 2 ? radius_z : -radius_z;
            }
            ASSERT_TRUE(holds(over, at(dx, dz))) << i << ' ' << radius_x;
        }
    }
    EXPECT_GT(too_large, 20);  // both kinds of boxes were met
    EXPECT_LT(too_large, 380);
}

TEST(OracleSurface, BoundsExceedTheLinearPartByTheSquareOfTheBox) {
    const Surface surface(test::sea_of_24_waves(3), 0);
    const Surface::Local local(surface, {0, 0});
    const auto excess = [&](double radius) {
        Jet<Interval> middle, over;
        EXPECT_TRUE(local.bounds(0.3, 0.2, radius, radius, middle, over));
        const Jet<double> jet = local.at(0.3, 0.2);
        return 0.5 * width(over.x) - radius * (std::abs(jet.xx) + std::abs(jet.xz));
    };
    EXPECT_NEAR(excess(1e-3) / excess(1e-4), 100, 0.1);
}

TEST(OracleSurface, IsTheSceneWater) {
    const scene::Water water = test::sea_of_24_waves(5);
    const ocean::WaterSurface other(water);
    const Oracle oracle(water, test::sun_at(50), 3.25);
    const Surface surface(water, 3.25);
    for (std::uint64_t i = 0; i < 100; ++i) {
        const double x = random_between(-20, 20, i, 0), z = random_between(-20, 20, i, 1);
        const ocean::SurfaceSample sample = other.sample(x, z, 3.25);
        const Jet<double> jet = Surface::Local(surface, {x, z}).at(0, 0);
        // 24 waves whose phases of up to 1200 rad are rounded to 2e-13 there.
        EXPECT_NEAR(jet.height, sample.height, 1e-13);
        EXPECT_NEAR(jet.x, sample.slope.x, 1e-12);
        EXPECT_NEAR(jet.z, sample.slope.y, 1e-12);
        EXPECT_NEAR(jet.xx, sample.d2[0], 1e-10);
        EXPECT_NEAR(jet.xz, sample.d2[1], 1e-10);
        EXPECT_NEAR(jet.zz, sample.d2[2], 1e-10);
        EXPECT_NEAR(oracle.land({x, z}, -1).water_point.y, sample.height, 1e-13);
    }
}

/// Vector form of Snell's law or the mirror, in 64 bits and as in the textbook, on the other surface code.
struct Expected {
    glm::dvec2 position;
    glm::dvec3 direction;
};
Expected expected_landing(const scene::Water& water, const scene::Light& light, Event event, glm::dvec2 uv,
                          double plane) {
    using vec3 = glm::vec<3, long double>;
    const Jet<long double> jet = exact_jet(water, 0, uv.x, uv.y);
    const vec3 point(uv.x, jet.height, uv.y);
    const vec3 normal = glm::normalize(vec3(-jet.x, 1, -jet.z));
    const vec3 in = light.type == scene::LightType::sun ? vec3(light.direction)
                                                        : glm::normalize(point - vec3(light.position));
    const vec3 out = event == Event::reflection
                         ? glm::reflect(in, normal)
                         : glm::refract(in, normal, 1 / static_cast<long double>(water.refractive_index));
    const long double t = (plane - point.y) / out.y;
    return {{static_cast<double>(point.x + t * out.x), static_cast<double>(point.z + t * out.z)},
            glm::dvec3(out)};
}

class LandingMap : public testing::TestWithParam<std::pair<Event, scene::LightType>> {};
INSTANTIATE_TEST_SUITE_P(Chains, LandingMap,
                         testing::Values(std::pair(Event::transmission, scene::LightType::sun),
                                         std::pair(Event::transmission, scene::LightType::point),
                                         std::pair(Event::reflection, scene::LightType::sun),
                                         std::pair(Event::reflection, scene::LightType::point)),
                         [](const auto& chain) {
                             return std::string(chain.param.first == Event::transmission ? "refracted"
                                                                                         : "reflected") +
                                    (chain.param.second == scene::LightType::sun ? "Sun" : "Lamp");
                         });

TEST_P(LandingMap, IsSnellsLawAndItsJacobianTheDifferences) {
    const auto [event, type] = GetParam();
    const scene::Water water = test::sea_of_24_waves(5);
    const scene::Light light =
        type == scene::LightType::sun ? test::sun_at(50, 20) : test::lamp_at({0.5, 2, -0.5});
    const Oracle oracle(water, light, 0, event);
    const double plane = event == Event::transmission ? -3 : 3;
    for (std::uint64_t i = 0; i < 100; ++i) {
        const glm::dvec2 uv(random_between(-2, 2, i, 0), random_between(-2, 2, i, 1));
        const LandingPoint point = oracle.land(uv, plane);
        EXPECT_TRUE(point.lands);
        const Expected expected = expected_landing(water, light, event, uv, plane);
        EXPECT_LT(glm::distance(point.position, expected.position), 1e-13);
        EXPECT_LT(glm::distance(point.direction, expected.direction), 1e-14);
        // Central differences: h^2 X''' / 6, with X''' of up to 3 m x 24 x 0.02 x 42^3 / m^2, is 1e-6.
        constexpr double h = 1e-5;
        for (int axis = 0; axis < 2; ++axis) {
            glm::dvec2 step(0);
            step[axis] = h;
            const glm::dvec2 slope = (expected_landing(water, light, event, uv + step, plane).position -
                                      expected_landing(water, light, event, uv - step, plane).position) /
                                     (2 * h);
            EXPECT_LT(glm::distance(point.jacobian[axis], slope), 2e-6);
        }
    }
}

}  // namespace
}  // namespace dapple::oracle
