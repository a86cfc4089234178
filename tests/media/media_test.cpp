#include "media/media.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "base/hash.h"
#include "grids/density_grid.h"
#include "media/grid_walk.h"
#include "media/phase.h"

namespace dapple::media {
namespace {

using scene::MediumSide;

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Random numbers in [0, 1) that are the same in every run.
class Dice {
public:
    explicit Dice(std::uint64_t seed) : seed_(seed) {}
    double roll() { return hash_uniform(seed_, 0, next_++, 0); }
    double roll(double low, double high) { return low + (high - low) * roll(); }
    glm::dvec3 point(double low, double high) {
        const double x = roll(low, high), y = roll(low, high);
        return {x, y, roll(low, high)};
    }
    glm::dvec3 direction() {
        const double y = roll(-1, 1), angle = roll(0, 2 * kPi), r = std::sqrt(1 - y * y);
        return {r * std::cos(angle), y, r * std::sin(angle)};
    }

private:
    std::uint64_t seed_, next_ = 0;
};

scene::Medium box_medium(glm::dvec3 size) {
    scene::Medium medium;
    medium.type = scene::MediumType::box;
    medium.size = size;
    medium.extinction = {1, 2, 3};
    medium.albedo = {0.5, 0.25, 0};
    return medium;
}

scene::FrameScene scene_of(const std::vector<scene::Medium>& media,
                           std::vector<std::shared_ptr<const grids::DensityGrid>> grids = {}) {
    scene::FrameScene scene;
    scene.state.media = media;
    grids.resize(media.size());
    scene.medium_grids = std::move(grids);
    return scene;
}

void add_water(scene::FrameScene& scene, glm::dvec3 absorption, glm::dvec3 scattering) {
    scene.state.water.emplace();
    scene.state.water->absorption = absorption;
    scene.state.water->scattering = scattering;
}

/// Values at (i, j, k) from low, as a grid of the file's own space with `voxel` m a voxel.
std::shared_ptr<const grids::DensityGrid> grid_of(glm::ivec3 low, glm::ivec3 size, double voxel,
                                                  const std::function<double(glm::ivec3)>& value,
                                                  std::size_t most_blocks = grids::DensityGrid::kMostBlocks) {
    std::vector<float> values;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                values.push_back(static_cast<float>(value(low + glm::ivec3(x, y, z))));
    return grids::DensityGrid::from_values(low, size, values, glm::scale(glm::dmat4(1), glm::dvec3(voxel)),
                                           most_blocks);
}

scene::Medium grid_medium() {
    scene::Medium medium;
    medium.type = scene::MediumType::grid;
    medium.extinction = {1, 2, 3};
    return medium;
}

/// Integral of one component's density by many small steps.
double marched(const Media& media, std::size_t component, glm::dvec3 origin, glm::dvec3 direction,
               double length, int steps, bool in_water = false) {
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        sum += media.density(component, origin + length * (i + 0.5) / steps * direction, in_water);
    return sum * length / steps;
}

double hermite(const DensityProfile& profile, std::size_t component, double t) {
    std::size_t i = 0;
    while (i + 2 < profile.place.size() && profile.place[i + 1] <= t) ++i;
    const std::size_t a = i * profile.components + component, b = a + profile.components;
    const double h = profile.place[i + 1] - profile.place[i], u = (t - profile.place[i]) / h;
    // Slopes at the ends: the densities just inside; the later one by the cubic's own Simpson rule.
    const double first = static_cast<double>(profile.density[a]),
                 middle = static_cast<double>(profile.middle[a]);
    const double last = 6 * (profile.column[b] - profile.column[a]) / h - first - 4 * middle;
    const double v = 1 - u;
    return profile.column[a] * v * v * (1 + 2 * u) + profile.column[b] * u * u * (1 + 2 * v) +
           h * (first * u * v * v - last * u * u * v);
}

TEST(Media, ASceneWithoutMediaHasNone) {
    const Media media{scene::FrameScene()};
    ASSERT_EQ(media.components().size(), 1U);
    for (const bool in_water : {false, true}) {
        EXPECT_FALSE(media.bounded(in_water));
        EXPECT_FALSE(media.scatters(in_water));
        EXPECT_FALSE(media.may_meet({0, 0, 0}, {0, 1, 0}, 1e9, in_water));
        EXPECT_EQ(media.optical_depth({0, 0, 0}, {0, 1, 0}, kInfinity, in_water), glm::dvec3(0));
    }
    EXPECT_EQ(media.density(0, {0, 0, 0}, false), 0);
    EXPECT_EQ(media.phase(0, 0.5), 0.25 / kPi);
}

TEST(Media, TheWaterIsEverywhereInTheWater) {
    scene::FrameScene scene = scene_of({});
    add_water(scene, {0.1, 0.2, 0}, {0.3, 0, 0});
    scene.state.water->phase.type = scene::PhaseType::henyey_greenstein;
    scene.state.water->phase.anisotropy = 0.5;
    const Media media(scene);
    EXPECT_TRUE(media.scatters(true));
    EXPECT_FALSE(media.scatters(false));
    EXPECT_FALSE(media.bounded(true));
    EXPECT_EQ(media.optical_depth({0, -1, 0}, {0, -1, 0}, 2, true),
              2.0 * (glm::dvec3(0.1, 0.2, 0) + glm::dvec3(0.3, 0, 0)));
    EXPECT_EQ(media.optical_depth({0, -1, 0}, {0, -1, 0}, kInfinity, true),
              glm::dvec3(kInfinity, kInfinity, 0));
    EXPECT_EQ(media.optical_depth({0, 1, 0}, {0, 1, 0}, kInfinity, false), glm::dvec3(0));
    EXPECT_NEAR(media.phase(0, 1), 1.5 / (0.25 * 4 * kPi), 1e-12);
    const DensityProfile profile = media.profile({0, -1, 0}, {1, 0, 0}, 3, true);
    EXPECT_EQ(profile.place, (std::vector<double>{0, 3}));
    EXPECT_EQ(profile.column[1], 3);
    EXPECT_EQ(profile.density[0], 1);
    EXPECT_EQ(media.profile({0, 1, 0}, {1, 0, 0}, 3, false).column[1], 0);
}

TEST(Media, ABoxIsCrossedAsItIsSeen) {
    scene::Medium medium = box_medium({2, 4, 6});
    medium.density = 0.5;
    const Media media(scene_of({medium}));
    const auto depth = [&](glm::dvec3 origin, glm::dvec3 direction, double length) {
        const glm::dvec3 d = media.optical_depth(origin, direction, length, false);
        EXPECT_DOUBLE_EQ(d.y, 2 * d.x);
        EXPECT_DOUBLE_EQ(d.z, 3 * d.x);
        return 2 * d.x;  // m in the box
    };
    EXPECT_DOUBLE_EQ(depth({-5, 0, 0}, {1, 0, 0}, kInfinity), 2);
    EXPECT_DOUBLE_EQ(depth({-5, 0, 0}, {1, 0, 0}, 5), 1);
    EXPECT_DOUBLE_EQ(depth({-5, 0, 0}, {1, 0, 0}, 3), 0);
    EXPECT_DOUBLE_EQ(depth({-5, 0, 0}, {-1, 0, 0}, 100), 0);
    EXPECT_DOUBLE_EQ(depth({0, 0, 0}, {0, -1, 0}, kInfinity), 2);    // from inside
    EXPECT_DOUBLE_EQ(depth({0.5, 0, 1}, {0, 0, 1}, 1), 1);           // both ends inside
    EXPECT_DOUBLE_EQ(depth({0, 2.0000001, 0}, {1, 0, 0}, 100), 0);   // parallel to a face, beside it
    EXPECT_DOUBLE_EQ(depth({-5, 1.9999999, 0}, {1, 0, 0}, 100), 2);  // and just inside
    EXPECT_DOUBLE_EQ(depth({0, 0, 0}, {0, 1, 0}, 0), 0);
    // Through the middle at a slant: 2 m of width at 3 : 4.
    EXPECT_NEAR(depth({-3, -4, 0}, {0.6, 0.8, 0}, 100), 2 / 0.6, 1e-12);
    // Grazing an edge.
    const double s = std::sqrt(0.5);
    EXPECT_NEAR(depth(glm::dvec3(1, 2, 0) + 5.0 * glm::dvec3(-s, s, 0), {s, -s, 0}, 100), 0, 1e-12);
    EXPECT_NEAR(depth(glm::dvec3(0.9, 2, 0) + 5.0 * glm::dvec3(-s, s, 0), {s, -s, 0}, 100), 0.1 / s, 1e-12);
    EXPECT_TRUE(media.may_meet({-5, 0, 0}, {1, 0, 0}, kInfinity, false));
    EXPECT_FALSE(media.may_meet({-5, 0, 0}, {1, 0, 0}, 3, false));
    EXPECT_EQ(media.density(1, {0.9, 1.9, -2.9}, false), 0.5);
    EXPECT_EQ(media.density(1, {1.1, 0, 0}, false), 0);
}

TEST(Media, LengthsAreThoseOfTheWorldWhateverTheBoxIsTurnedAndScaledTo) {
    scene::Medium medium = box_medium({1, 2, 3});
    medium.transform = {{10, -2, 3}, {0.3, -1.1, 0.7}, {2, 0.5, 7}};
    const scene::FrameScene scene = scene_of({medium});
    const Media media(scene);
    const glm::dmat4 world = scene::world_from_object(medium.transform);
    Dice dice(1);
    int met = 0;
    for (int i = 0; i < 300; ++i) {
        // Two points of the box, and a segment from beyond one to beyond the other.
        const glm::dvec3 a(world * glm::dvec4(dice.point(-0.5, 0.5) * medium.size, 1));
        const glm::dvec3 direction = dice.direction();
        const glm::dvec3 origin = a - 100.0 * direction;
        const double inside = media.optical_depth(origin, direction, 200, false).x;
        // The box's own slabs, in its space: t of a point a + t * direction.
        double low = -kInfinity, high = kInfinity;
        for (int axis = 0; axis < 3; ++axis) {
            const glm::dvec3 edge(world[axis]);
            const double half = 0.5 * medium.size[axis] * glm::dot(edge, edge);
            const double o = glm::dot(a - glm::dvec3(world[3]), edge), d = glm::dot(direction, edge);
            low = std::max(low, std::min((-half - o) / d, (half - o) / d));
            high = std::min(high, std::max((-half - o) / d, (half - o) / d));
        }
        EXPECT_NEAR(inside, high - low, 1e-11);  // 100 m lose so much of 2e-16
        met += inside > 0 ? 1 : 0;
    }
    EXPECT_EQ(met, 300);
}

TEST(Media, SidesCutMediaOff) {
    scene::Medium everywhere = box_medium({2, 2, 2}), air = everywhere, water = everywhere,
                  above = everywhere;
    air.side = MediumSide::air;
    water.side = MediumSide::water;
    above.transform.position.y = 5;
    scene::FrameScene scene = scene_of({everywhere, air, water, above});
    add_water(scene, {0, 0, 0}, {0, 0, 0});
    auto mesh = std::make_shared<scene::WaterMesh>();
    mesh->largest_height = 0.5;
    scene.water = mesh;
    const Media media(scene);
    EXPECT_DOUBLE_EQ(media.optical_depth({-5, 0, 0}, {1, 0, 0}, 10, false).x, 4);
    EXPECT_DOUBLE_EQ(media.optical_depth({-5, 0, 0}, {1, 0, 0}, 10, true).x, 4);
    const DensityProfile in_air = media.profile({-5, 0, 0}, {1, 0, 0}, 10, false);
    const std::size_t last = (in_air.place.size() - 1) * in_air.components;
    EXPECT_DOUBLE_EQ(in_air.column[last + 1], 2);
    EXPECT_DOUBLE_EQ(in_air.column[last + 2], 2);
    EXPECT_EQ(in_air.column[last + 3], 0);
    EXPECT_EQ(media.density(2, {0, 0, 0}, true), 0);
    EXPECT_EQ(media.density(3, {0, 0, 0}, true), 1);
    // What lies above all of the water is not in it, though it may be everywhere.
    EXPECT_EQ(media.density(4, {0, 5, 0}, true), 0);
    EXPECT_EQ(media.density(4, {0, 5, 0}, false), 1);
    scene.state.water.reset();
    scene.water.reset();
    const Media dry(scene);
    EXPECT_FALSE(dry.bounded(true));
    EXPECT_DOUBLE_EQ(dry.optical_depth({-5, 0, 0}, {1, 0, 0}, 10, false).x, 4);
}

TEST(Media, WhatDoesNotScatterOrIsEmptyCostsNothing) {
    scene::Medium absorbing = box_medium({1, 1, 1}), thin = absorbing, clear = absorbing;
    absorbing.albedo = glm::dvec3(0);
    thin.density = 0;
    clear.extinction = glm::dvec3(0);
    EXPECT_FALSE(Media(scene_of({thin, clear})).bounded(false));
    EXPECT_TRUE(Media(scene_of({absorbing})).bounded(false));
    EXPECT_FALSE(Media(scene_of({absorbing})).scatters(false));
    const Media empty(scene_of({grid_medium(), grid_medium()},
                               {nullptr, grid_of({0, 0, 0}, {2, 2, 2}, 1, [](glm::ivec3) { return 0; })}));
    EXPECT_FALSE(empty.bounded(false));
    EXPECT_EQ(empty.components().size(), 3U);
}

TEST(Media, HugeAndTinyDensitiesStayNumbers) {
    scene::Medium medium = box_medium({1, 1, 1});
    for (const double density : {1e-300, 1e12}) {
        medium.density = density;
        const Media media(scene_of({medium}));
        const glm::dvec3 depth = media.optical_depth({-5, 0.1, 0.2}, {1, 0, 0}, kInfinity, false);
        EXPECT_NEAR(depth.x / density, 1, 1e-12);
        EXPECT_TRUE(std::isfinite(depth.z));
        EXPECT_EQ(glm::exp(-depth).z, density > 1 ? 0 : 1);
    }
}

TEST(Media, FarFromTheOriginNothingIsLost) {
    scene::Medium medium = grid_medium();
    const auto grid = grid_of({-4, -4, -4}, {9, 9, 9}, 0.25, [](glm::ivec3 v) { return 1 + 0.1 * v.x; });
    const glm::dvec3 far(100000, 0, -100000);
    const Media near(scene_of({medium}, {grid}));
    medium.transform.position = far + glm::dvec3(0.5, 0, 0);
    scene::FrameScene scene = scene_of({medium}, {grid});
    scene.origin = far;
    const Media there(scene);
    Dice dice(2);
    for (int i = 0; i < 100; ++i) {
        const glm::dvec3 origin = dice.point(-2, 2), direction = dice.direction();
        // 100 km in double are 1.5e-11 m.
        EXPECT_NEAR(there.optical_depth(origin + glm::dvec3(0.5, 0, 0), direction, 5, false).x,
                    near.optical_depth(origin, direction, 5, false).x, 1e-9);
    }
}

TEST(Media, PlacesThatAreNoNumbersHoldNothing) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Media media(scene_of({box_medium({2, 2, 2}), grid_medium()},
                               {nullptr, grid_of({0, 0, 0}, {9, 9, 9}, 1, [](glm::ivec3) { return 1; })}));
    for (const glm::dvec3 bad :
         {glm::dvec3(nan), glm::dvec3(nan, 0.5, 0.5), glm::dvec3(kInfinity, 0.5, 0.5)}) {
        EXPECT_EQ(media.optical_depth(bad, {0.6, -0.8, 0}, kInfinity, false), glm::dvec3(0));
        EXPECT_FALSE(media.may_meet(bad, {0.6, -0.8, 0}, kInfinity, false));
        EXPECT_EQ(media.density(1, bad, false), 0);
        EXPECT_EQ(media.density(2, bad, false), 0);
    }
    EXPECT_EQ(media.optical_depth({0.5, 0.5, 0.5}, glm::dvec3(nan), 5, false), glm::dvec3(0));
}

TEST(MediaGrid, ARampIsIntegratedExactly) {
    // Density x + 1 for x in [0, 40] voxels of 5 cm, from 1 to 41; beyond it falls to 0 within a voxel.
    const auto grid = grid_of({0, 0, 0}, {41, 12, 12}, 0.05, [](glm::ivec3 v) { return v.x + 1; });
    scene::Medium medium = grid_medium();
    medium.density = 2;
    medium.transform.position = {3, 0, 0};
    const Media media(scene_of({medium}, {grid}));
    // Level, from before to behind: 0.5 * 1 + sum of the trapezia + 0.5 * 41, in voxels.
    const double exact = 2 * 0.05 * (0.5 + 0.5 * (1 + 41) * 40 + 20.5);
    // Densities are floats, but these are whole numbers.
    EXPECT_NEAR(media.optical_depth({-1, 0.27, 0.3}, {1, 0, 0}, kInfinity, false).x, exact, 1e-11);
    EXPECT_NEAR(media.optical_depth({9, 0.27, 0.3}, {-1, 0, 0}, kInfinity, false).x, exact, 1e-11);
    // Both ends inside, at a slant.
    const glm::dvec3 a(3.25, 0.1, 0.1), b(4.5, 0.5, 0.4);
    const double mean = 2 * (1 + 0.5 * ((a.x - 3) + (b.x - 3)) / 0.05);
    EXPECT_NEAR(media.optical_depth(a, glm::normalize(b - a), glm::length(b - a), false).x,
                mean * glm::length(b - a), 1e-11);
    EXPECT_DOUBLE_EQ(media.density(1, {3.1, 0.2, 0.2}, false), 2 * 3);
}

TEST(MediaGrid, FilesWithZUpAreTurned) {
    const auto grid = grid_of({0, 0, 0}, {2, 3, 9}, 1, [](glm::ivec3 v) { return v.z + 10 * v.y + 1; });
    scene::Medium medium = grid_medium();
    medium.z_up = true;
    const Media media(scene_of({medium}, {grid}));
    // The file's (x, y, z) is the world's (x, z, -y).
    EXPECT_DOUBLE_EQ(media.density(1, {0.5, 4, -2}, false), 25);
    EXPECT_DOUBLE_EQ(media.density(1, {0.5, 4, 2}, false), 0);
}

/// A random cloud of many blocks, most of them empty.
std::shared_ptr<const grids::DensityGrid> cloud(std::uint64_t seed,
                                                std::size_t most_blocks = grids::DensityGrid::kMostBlocks) {
    const auto density = [seed](glm::ivec3 v) {
        Dice block(seed + static_cast<std::uint64_t>((v.x >> 3) + 100) * 10007 +
                   static_cast<std::uint64_t>((v.y >> 3) + 100) * 101 +
                   static_cast<std::uint64_t>((v.z >> 3) + 100));
        if (block.roll() < 0.7) return 0.0;
        Dice voxel(seed * 31 + static_cast<std::uint64_t>(v.x + 100) * 1000003 +
                   static_cast<std::uint64_t>(v.y + 100) * 1009 + static_cast<std::uint64_t>(v.z + 100));
        return voxel.roll() < 0.1 ? 0.0 : voxel.roll(0, 5);
    };
    return grid_of({-30, -13, 5}, {61, 40, 33}, 0.1, density, most_blocks);
}

TEST(MediaGrid, ACloudEqualsFineMarching) {
    scene::Medium medium = grid_medium();
    medium.density = 0.7;
    medium.transform = {{1, 2, 0}, {0.4, 0.8, -0.3}, {1, 2, 0.5}};
    const Media media(scene_of({medium}, {cloud(7)}));
    Dice dice(3);
    double sum = 0;
    for (int i = 0; i < 60; ++i) {
        glm::dvec3 direction = dice.direction();
        if (i % 6 == 0) direction = glm::dvec3(i % 12 == 0 ? 1 : -1, 0, 0);
        const glm::dvec3 origin = glm::dvec3(1, 2, 1) + dice.point(-2, 2);
        const double length = dice.roll(0.1, 6);
        const double depth = media.optical_depth(origin, direction, length, false).x;
        // Cells are 5 cm or more; midpoint steps of 0.3 mm or less leave curvature * step^2 / 24 of kinks.
        EXPECT_NEAR(depth, marched(media, 1, origin, direction, length, 20000), 2e-4) << i;
        sum += depth;
    }
    EXPECT_GT(sum, 10);  // there was a cloud
}

TEST(MediaGrid, PartsOfASegmentSumToIt) {
    scene::Medium medium = grid_medium();
    const Media media(scene_of({medium}, {cloud(9)}));
    Dice dice(4);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 origin = dice.point(-3, 3), direction = dice.direction();
        const double cut = dice.roll(0, 6);
        const double whole = media.optical_depth(origin, direction, 6, false).x;
        EXPECT_NEAR(media.optical_depth(origin, direction, cut, false).x +
                        media.optical_depth(origin + cut * direction, direction, 6 - cut, false).x,
                    whole, 1e-11);
        EXPECT_NEAR(media.optical_depth(origin + 6.0 * direction, -direction, 6, false).x, whole, 1e-11);
    }
}

TEST(MediaGrid, RaysInThePlanesOfVoxelsLoseNothing) {
    const Media media(
        scene_of({grid_medium()}, {grid_of({0, 0, 0}, {16, 16, 16}, 1, [](glm::ivec3) { return 1; })}));
    for (const double y : {0.0, 7.0, 8.0, 15.0})
        for (const double z : {0.0, 7.0, 8.0, 15.0})
            for (const double x : {-5.0, -1.0, 0.0, 8.0})
                EXPECT_NEAR(media.optical_depth({x, y, z}, {1, 0, 0}, kInfinity, false).x,
                            x < 0 ? 16 : 15.5 - x, 1e-11)
                    << x << ' ' << y << ' ' << z;
    // Along the diagonal through all corners.
    const glm::dvec3 diagonal = glm::normalize(glm::dvec3(1, 1, 1));
    EXPECT_NEAR(media.optical_depth({0, 0, 0}, diagonal, 15 * std::sqrt(3.0), false).x, 15 * std::sqrt(3.0),
                1e-11);
    EXPECT_NEAR(media.optical_depth({15, 15, 15}, -diagonal, 15 * std::sqrt(3.0), false).x,
                15 * std::sqrt(3.0), 1e-11);
    // -0 and the smallest of slopes.
    EXPECT_NEAR(media.optical_depth({-5, 3, 3}, {1, -0.0, 1e-300}, kInfinity, false).x, 16, 1e-11);
}

TEST(MediaGrid, VoxelsFarApartAreFound) {
    std::vector<float> one{2};
    const auto far = [&](glm::ivec3 at) {
        return grids::DensityGrid::from_values(at, {1, 1, 1}, one, glm::dmat4(1));
    };
    const Media small(scene_of({grid_medium()}, {far({5, -5, 5})}));
    EXPECT_NEAR(small.optical_depth({0, -5, 5}, {1, 0, 0}, 10, false).x, 2, 1e-12);
    EXPECT_EQ(small.optical_depth({0, -3.9, 5}, {1, 0, 0}, 10, false).x, 0);
    std::vector<float> row(3000, 0);
    row.front() = row.back() = 1;
    const auto wide = grids::DensityGrid::from_values({0, 0, 0}, {3000, 1, 1}, row, glm::dmat4(1));
    const Media line(scene_of({grid_medium()}, {wide}));
    EXPECT_NEAR(line.optical_depth({-10, 0, 0}, {1, 0, 0}, kInfinity, false).x, 2, 1e-9);
    const DensityProfile profile = line.profile({-10, 0, 0}, {1, 0, 0}, 3100, false);
    EXPECT_LT(profile.place.size(), 30U);  // none where nothing is
}

TEST(MediaGrid, BlocksThatAreTooManyToNoteAreAskedFor) {
    const auto grid = cloud(13), without = cloud(13, 0);
    ASSERT_NE(grid->cell_blocks(), nullptr);
    ASSERT_EQ(without->cell_blocks(), nullptr);
    const GridWalk noted(grid), asked(without);
    Dice dice(6);
    double sum = 0;
    for (int i = 0; i < 100; ++i) {
        const Line line{dice.point(-30, 30), 10.0 * dice.direction()};
        const Interval part = inside_box(line, noted.low(), noted.high(), {0, 10});
        if (part.empty()) continue;
        EXPECT_EQ(asked.column(line, part), noted.column(line, part));
        sum += noted.column(line, part);
    }
    EXPECT_GT(sum, 10);
}

TEST(MediaProfile, HoldsWhatTheSegmentMeets) {
    scene::Medium smoke = grid_medium(), fog = box_medium({3, 2, 2}), mist = box_medium({1, 9, 9});
    smoke.density = 0.7;
    smoke.transform = {{0, 0, -2}, {0.4, 0.8, -0.3}, {1, 1, 1}};
    mist.density = 4;
    scene::FrameScene scene = scene_of({smoke, fog, mist}, {cloud(11), nullptr, nullptr});
    add_water(scene, {0.1, 0.1, 0.1}, {0, 0, 0});
    const Media media(scene);
    Dice dice(5);
    std::size_t longest = 0;
    for (int i = 0; i < 60; ++i) {
        const bool in_water = i % 2 == 1;
        const glm::dvec3 origin = dice.point(-3, 3), direction = dice.direction();
        const double length = dice.roll(0.5, 6);
        const DensityProfile profile = media.profile(origin, direction, length, in_water);
        ASSERT_EQ(profile.components, 4U);
        const std::size_t places = profile.place.size();
        longest = std::max(longest, places);
        ASSERT_EQ(profile.density.size(), places * 4);
        ASSERT_EQ(profile.middle.size(), places * 4);
        ASSERT_EQ(profile.column.size(), places * 4);
        EXPECT_EQ(profile.place.front(), 0);
        EXPECT_EQ(profile.place.back(), length);
        glm::dvec3 depth(0);
        for (std::size_t c = 0; c < 4; ++c) {
            EXPECT_EQ(profile.column[c], 0);
            depth += profile.column[(places - 1) * 4 + c] * media.components()[c].extinction;
            for (std::size_t k = 0; k + 1 < places; ++k) {
                const double h = profile.place[k + 1] - profile.place[k];
                ASSERT_GT(h, 0);
                const auto at = [&](double u) {
                    return media.density(c, origin + (profile.place[k] + u * h) * direction, in_water);
                };
                if (h < 1e-6) continue;  // a point cannot be told from the faces beside it
                // Densities are rounded to float; a point just after a face is 1e-9 of the way inside.
                const double size = 1e-5 * (1 + media.components()[c].extinction.x);
                EXPECT_NEAR(static_cast<double>(profile.density[k * 4 + c]), at(1e-9), size);
                EXPECT_NEAR(static_cast<double>(profile.middle[k * 4 + c]), at(0.5), size);
                // Hermite misses a quartic by p''' h^4 / 384: nothing in boxes, and p''' h^3 is some tens of
                // random voxels of up to 3.5.
                const double t = profile.place[k] + 0.3 * h;
                const double column =
                    profile.column[k * 4 + c] + h * 0.3 / 6 * (at(1e-9) + 4 * at(0.15) + at(0.3));
                EXPECT_NEAR(hermite(profile, c, t), column, (c == 1 ? 0.1 : 1e-5) * h);
            }
        }
        EXPECT_NEAR(depth.x, media.optical_depth(origin, direction, length, in_water).x, 1e-5);
    }
    EXPECT_GT(longest, 30U);
    EXPECT_EQ(media.profile({0, 0, 0}, {1, 0, 0}, 0, true).place, (std::vector<double>{0, 0}));
}

TEST(MediaPhase, EachMediumHasItsOwn) {
    scene::Medium first = box_medium({1, 1, 1}), second = first;
    first.phase.type = scene::PhaseType::two_lobe;
    second.phase.type = scene::PhaseType::table;
    second.phase.samples = {{0.1, 3}, {1, 1}, {2, 0}, {3, 0.5}};
    const Media media(scene_of({first, second}));
    EXPECT_EQ(media.phase(0, 0.3), 0.25 / kPi);
    EXPECT_GT(media.phase(1, 1), media.phase(1, 0));
    EXPECT_NEAR(media.phase(2, std::cos(1.5)) / media.phase(2, std::cos(1.0)), 0.5, 1e-12);
}

TEST(MediaPhase, TablesAreNormalisedAndLinearInTheAngle) {
    scene::PhaseFunction table;
    table.type = scene::PhaseType::table;
    table.samples = {{0.2, 30}, {0.5, 4}, {1.5, 1}, {1.6, 0}, {2.9, 2}};
    const Phase phase(table);
    double sum = 0;
    constexpr int kSteps = 400000;
    for (int i = 0; i < kSteps; ++i) {
        const double angle = kPi * (i + 0.5) / kSteps;
        sum += 2 * kPi * std::sin(angle) * phase.at(std::cos(angle)) * kPi / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-9);  // midpoints, with kinks: the square of the step
    const double unit = phase.at(std::cos(1.5));
    EXPECT_NEAR(phase.at(std::cos(0.35)) / unit, 17, 1e-9);
    EXPECT_NEAR(phase.at(1) / unit, 30, 1e-9);  // as at the first angle
    EXPECT_NEAR(phase.at(-1) / unit, 2, 1e-9);  // and the last
    EXPECT_NEAR(phase.at(1 + 1e-15) / unit, 30, 1e-9);
    table.samples = {{0, 7}, {kPi, 7}};
    EXPECT_NEAR(Phase(table).at(0.123), 0.25 / kPi, 1e-15);
}

}  // namespace
}  // namespace dapple::media
