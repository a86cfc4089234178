// Proven paths under seas of 24 waves: against searches from many seeds, and the counts' own laws.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "methods/oracle_scenes.h"
#include "methods/reference/oracle.h"

namespace dapple::oracle {
namespace {

using test::random_between;

constexpr glm::dvec3 kUp{0, 1, 0};

/// Landing points of a grid of water points; candidates near a receiver start Newton's iteration.
class SeedSearch {
public:
    SeedSearch(const Oracle& oracle, double plane, double reach)
        : oracle_(oracle), plane_(plane), cells_(static_cast<int>(reach / kSpacing)) {
        for (int row = -cells_; row <= cells_; ++row) {
            for (int column = -cells_; column <= cells_; ++column) {
                const glm::dvec2 uv(kSpacing * column, kSpacing * row);
                seeds_.push_back({uv, oracle.land(uv, plane).position});
            }
        }
    }

    std::vector<glm::dvec2> roots(glm::dvec2 target) const {
        std::vector<glm::dvec2> found;
        for (const Seed& seed : seeds_) {
            if (glm::distance(seed.landing, target) > kNear) continue;
            glm::dvec2 uv = seed.uv;
            for (int step = 0; step < 30; ++step) {
                const LandingPoint point = oracle_.land(uv, plane_);
                glm::dvec2 move = glm::inverse(point.jacobian) * (target - point.position);
                const double length = glm::length(move);
                if (!(length < 1)) break;
                if (length > 0.02) move *= 0.02 / length;
                uv += move;
                if (length < 1e-11) {
                    const auto same = [&](const glm::dvec2& root) { return glm::distance(root, uv) < 1e-8; };
                    if (std::ranges::none_of(found, same)) found.push_back(uv);
                    break;
                }
            }
        }
        return found;
    }

private:
    static constexpr double kSpacing = 0.02;  // m
    static constexpr double kNear = 0.08;     // m; cells land on at most some 0.06 m
    struct Seed {
        glm::dvec2 uv, landing;
    };
    const Oracle& oracle_;
    double plane_;
    int cells_;
    std::vector<Seed> seeds_;
};

void expect_seeds_find_the_same(const Oracle& oracle, double plane, double reach, std::uint64_t count) {
    const SeedSearch search(oracle, plane, reach);
    std::size_t total = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const glm::dvec2 at(random_between(-0.5, 0.5, i, 0), random_between(-0.5, 0.5, i, 1));
        const Result result = oracle.paths({at.x, plane, at.y}, plane < 0 ? kUp : -kUp);
        EXPECT_TRUE(result.proven);
        const std::vector<glm::dvec2> roots = search.roots(at);
        EXPECT_EQ(result.paths.size(), roots.size()) << at.x << ' ' << at.y;
        for (const Path& path : result.paths) {
            double nearest = 1;
            for (const glm::dvec2& root : roots)
                nearest = std::min(nearest, glm::distance(root, {path.water_point.x, path.water_point.z}));
            // Newton's last step of 1e-11 squares to far below; nearer folds lose digits.
            EXPECT_LT(nearest, 1e-10 / std::min(1.0, std::abs(path.jacobian)));
        }
        total += result.paths.size();
    }
    EXPECT_GT(static_cast<double>(total), 1.05 * static_cast<double>(count));  // several sheets were met
}

TEST(Sea, PathsUnderTheSunAreThoseOfManySeeds) {
    const Oracle oracle(test::sea_of_24_waves(1), test::sun_at(50), 0.7);
    expect_seeds_find_the_same(oracle, -2, 3.5, 150);
    expect_seeds_find_the_same(oracle, -4, 5, 100);
}

TEST(Sea, PathsFromALampAreThoseOfManySeeds) {
    const Oracle oracle(test::sea_of_24_waves(1), test::lamp_at({0.4, 6, 0.2}), 0.7);
    expect_seeds_find_the_same(oracle, -6, 3, 100);
}

TEST(Sea, ReflectedPathsAreThoseOfManySeeds) {
    const Oracle oracle(test::sea_of_24_waves(1), test::sun_at(50), 0.7, Event::reflection);
    expect_seeds_find_the_same(oracle, 0.6, 2.5, 100);
}

TEST(Sea, PathsAppearInPairsAcrossFolds) {
    const double depth = 4;
    const Oracle oracle(test::sea_of_24_waves(1), test::sun_at(50), 0);
    const auto determinant = [&](double u) {
        return glm::determinant(oracle.land({u, 0.3}, -depth).jacobian);
    };
    int folds = 0;
    for (double u = -3; u < 1; u += 0.02) {
        double low = u, high = u + 0.02;
        const bool negative = determinant(low) < 0;
        if (negative == (determinant(high) < 0)) continue;
        for (int step = 0; step < 60; ++step) {
            const double middle = 0.5 * (low + high);
            ((determinant(middle) < 0) == negative ? low : high) = middle;
        }
        const LandingPoint fold = oracle.land({low, 0.3}, -depth);
        EXPECT_FALSE(oracle.paths({fold.position.x, -depth, fold.position.y}, kUp).proven);
        // A micron to either side, across the fold: along J's left null vector.
        const glm::dmat2& j = fold.jacobian;
        const glm::dvec2 along = glm::length(j[0]) > glm::length(j[1]) ? j[0] : j[1];
        const glm::dvec2 across = 1e-6 * glm::normalize(glm::dvec2(-along.y, along.x));
        std::size_t counts[2];
        for (const int side : {0, 1}) {
            const glm::dvec2 at = fold.position + (side == 0 ? across : -across);
            const Result result = oracle.paths({at.x, -depth, at.y}, kUp);
            EXPECT_TRUE(result.proven);
            EXPECT_EQ(result.sign(), 1);
            EXPECT_LT(result.boxes, 2500u);  // 1200 are examined anywhere at this depth
            counts[side] = result.paths.size();
        }
        EXPECT_EQ(std::max(counts[0], counts[1]) - std::min(counts[0], counts[1]), 2u);
        ++folds;
    }
    EXPECT_GT(folds, 5);
}

class SeaDepth : public testing::TestWithParam<std::pair<double, double>> {};
INSTANTIATE_TEST_SUITE_P(MetresAndMeanPaths, SeaDepth,
                         testing::Values(std::pair(0.5, 1.0), std::pair(1.0, 1.0), std::pair(2.0, 1.11),
                                         std::pair(4.0, 2.0), std::pair(8.0, 5.89)),
                         [](const auto& depth) {
                             return std::to_string(static_cast<int>(1000 * depth.param.first)) + "mm";
                         });

TEST_P(SeaDepth, SignsSumToOneAndTheMeanCountIsTheMeanJacobian) {
    // Points are one to a cell of 0.5 m: paths of neighbours are then nearly independent.
    const auto [depth, published] = GetParam();
    constexpr int kSide = 14;
    double paths = 0, squares = 0, mean_jacobian = 0;
    for (const std::uint64_t seed : {1u, 2u}) {
        const Oracle oracle(test::sea_of_24_waves(seed), test::sun_at(50), 0);
        for (std::uint64_t i = 0; i < kSide * kSide; ++i) {
            const std::uint64_t column = i % kSide, row = i / kSide;
            const double x = 0.5 * (static_cast<double>(column) + random_between(0, 1, i, 0));
            const double z = 0.5 * (static_cast<double>(row) + random_between(0, 1, i, 1));
            const Result result = oracle.paths({x, -depth, z}, kUp);
            ASSERT_TRUE(result.proven);
            ASSERT_EQ(result.sign(), 1) << x << ' ' << z;
            ASSERT_EQ(result.paths.size() % 2, 1u);
            const auto count = static_cast<double>(result.paths.size());
            paths += count;
            squares += count * count;
        }
        double sum = 0;
        constexpr int kSamples = 20000;
        for (std::uint64_t i = 0; i < kSamples; ++i)
            sum += std::abs(glm::determinant(
                oracle.land({random_between(-8, 8, i, 2), random_between(-8, 8, i, 3)}, -depth).jacobian));
        mean_jacobian += 0.5 * sum / kSamples;
    }
    constexpr double kPoints = 2.0 * kSide * kSide;
    const double mean = paths / kPoints, deviation = std::sqrt(squares / kPoints - mean * mean);
    printf("%.1f m: mean paths %.3f +- %.3f, mean |det J| %.3f, published %.2f\n", depth, mean,
           deviation / std::sqrt(kPoints), mean_jacobian, published);
    // Points and rays have the same mean: the landing map covers the plane once, counted with signs.
    EXPECT_NEAR(mean, mean_jacobian, 4 * deviation / std::sqrt(kPoints) + 0.01);
    // Another sea of the same statistics: two draws of 24 lengths and headings differ by some 5 %.
    EXPECT_NEAR(mean_jacobian, published, 0.1 * published);
}

TEST(Sea, IsTheSameFarFromTheOrigin) {
    const scene::Water here = test::sea_of_24_waves(1);
    for (const double distance : {1e4, 1e5}) {
        scene::Water there = here;
        there.extent.center = {distance, -distance};
        for (scene::Wave& wave : there.surface.waves.waves) {
            const double k = 2 * std::numbers::pi / wave.length;
            const long double shift = static_cast<long double>(k * std::cos(wave.heading)) * distance -
                                      static_cast<long double>(k * std::sin(wave.heading)) * distance;
            wave.phase =
                static_cast<double>(std::remainder(wave.phase - shift, 2 * std::numbers::pi_v<long double>));
        }
        const Oracle near(here, test::sun_at(50), 0), far(there, test::sun_at(50), 0);
        for (std::uint64_t i = 0; i < 20; ++i) {
            // Multiples of 1 / 64 m are the same doubles in both places.
            const double x = std::round(64 * random_between(-4, 4, i, 0)) / 64;
            const Result a = near.paths({x, -4, 0.5}, kUp);
            const Result b = far.paths({distance + x, -4, -distance + 0.5}, kUp);
            ASSERT_TRUE(a.proven && b.proven);
            ASSERT_EQ(a.paths.size(), b.paths.size());
            // Phases agree to 1e-15 here and 2e-12 at 100 km, slopes to 1e-13 and landing points to 1e-12 m;
            // an irradiance of j^-1 is off by some 100 /m times that over j, which is rarely below 1e-2.
            EXPECT_NEAR(b.irradiance() / a.irradiance(), 1, 1e-7);
        }
    }
}

}  // namespace
}  // namespace dapple::oracle
