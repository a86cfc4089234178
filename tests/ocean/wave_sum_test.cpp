#include <gtest/gtest.h>

#include <numbers>

#include "base/hash.h"
#include "ocean/dispersion.h"
#include "ocean/reference.h"
#include "ocean/water_surface.h"

namespace dapple::ocean {
namespace {

// A gentle sea of 24 waves of 0.25 to 3 m on a patch away from the origin.
scene::Water gentle_sea() {
    scene::Water water;
    water.extent.center = {3, -7};
    water.extent.size = {12, 9};
    water.mesh_cells = 300;
    water.surface.waves.depth = 2;
    for (unsigned i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = 0.25 * std::pow(12.0, i / 23.0);
        wave.heading = 2 * std::numbers::pi * hash_uniform(5, 0, i, 0);
        wave.phase = 2 * std::numbers::pi * hash_uniform(5, 0, i, 1);
        wave.amplitude = 0.003 * wave.length * (i % 2 == 0 ? 1 : -1);
        water.surface.waves.waves.push_back(wave);
    }
    return water;
}

std::vector<ReferenceWave> references(const scene::Waves& waves) {
    std::vector<ReferenceWave> all;
    for (const scene::Wave& wave : waves.waves) {
        const double k = 2 * std::numbers::pi / wave.length;
        all.push_back({k * std::cos(wave.heading), k * std::sin(wave.heading),
                       angular_frequency(k, waves.depth), wave.amplitude, wave.phase});
    }
    return all;
}

TEST(WaveSum, GridEqualsTheDirectSumInEveryField) {
    const scene::Water water = gentle_sea();
    const WaterSurface surface(water);
    const double time = 37.25;
    const SurfaceGrid grid = surface.grid(time, kAllFields);
    ASSERT_EQ(grid.columns, 301);
    ASSERT_EQ(grid.rows, 226);  // square cells
    const std::vector<ReferenceWave> waves = references(water.surface.waves);
    std::array<double, kFieldCount> largest{};
    for (const ReferenceWave& wave : waves) {
        for (std::size_t f = 0; f < kFieldCount; ++f) largest[f] += wave.amplitudes()[f];
    }
    for (int row = 0; row < grid.rows; row += 7) {
        for (int column = 0; column < grid.columns; column += 11) {
            // To the end of the patch in exact arithmetic.
            const long double x = 3 + 12 * (static_cast<long double>(column) / 300 - 0.5L);
            const long double z = -7 + 9 * (static_cast<long double>(row) / 225 - 0.5L);
            std::array<long double, kFieldCount> sum{};
            for (const ReferenceWave& wave : waves) {
                const auto fields = wave.fields(x, z, time);
                for (std::size_t f = 0; f < kFieldCount; ++f) sum[f] += fields[f];
            }
            const auto at = static_cast<std::size_t>(row * grid.columns + column);
            for (std::size_t f = 0; f < kFieldCount; ++f) {
                // Phases are up to about 700 rad, so they are rounded by 1e-13 when made in double.
                EXPECT_NEAR(grid.values[f][at], static_cast<double>(sum[f]), 1e-12 * largest[f])
                    << "field " << f << " row " << row << " column " << column;
            }
        }
    }
}

TEST(WaveSum, OnlyWhatIsAskedForIsComputed) {
    const SurfaceGrid grid = WaterSurface(gentle_sea()).grid(0, kHeight | kSlopeRate);
    EXPECT_FALSE(grid[Field::height].empty());
    EXPECT_FALSE(grid[Field::slope_rate_z].empty());
    EXPECT_TRUE(grid[Field::slope_x].empty());
    EXPECT_TRUE(grid[Field::second_zz].empty());
}

TEST(WaveSum, SampleDerivativesAreThoseOfItsHeight) {
    const WaterSurface surface{gentle_sea()};
    // Central differences of order 6 with a step of 1/100 of the shortest wave: error (k h)^6 / 140 = 4e-10
    // of each derivative; round-off 1e-15 / h.
    const double h = 0.0025;
    const auto derivative = [&](const auto& f) {
        return (45 * (f(h) - f(-h)) - 9 * (f(2 * h) - f(-2 * h)) + (f(3 * h) - f(-3 * h))) / (60 * h);
    };
    for (unsigned i = 0; i < 20; ++i) {
        const double x = 12 * hash_uniform(1, 0, i, 0);
        const double z = 12 * hash_uniform(1, 0, i, 1);
        const double t = hash_uniform(1, 0, i, 2);
        const SurfaceSample s = surface.sample(x, z, t);
        const auto dx = [&](const auto& of) {
            return derivative([&](double d) { return of(surface.sample(x + d, z, t)); });
        };
        const auto dz = [&](const auto& of) {
            return derivative([&](double d) { return of(surface.sample(x, z + d, t)); });
        };
        const auto dt = [&](const auto& of) {
            return derivative([&](double d) { return of(surface.sample(x, z, t + d)); });
        };
        const auto height = [](const SurfaceSample& a) { return a.height; };
        const auto slope_x = [](const SurfaceSample& a) { return a.slope.x; };
        const auto slope_z = [](const SurfaceSample& a) { return a.slope.y; };
        EXPECT_NEAR(s.slope.x, dx(height), 1e-9);
        EXPECT_NEAR(s.slope.y, dz(height), 1e-9);
        EXPECT_NEAR(s.height_rate, dt(height), 1e-9);
        EXPECT_NEAR(s.slope_rate.x, dt(slope_x), 1e-8);
        EXPECT_NEAR(s.slope_rate.y, dt(slope_z), 1e-8);
        EXPECT_NEAR(s.d2[0], dx(slope_x), 1e-8);
        EXPECT_NEAR(s.d2[1], dz(slope_x), 1e-8);
        EXPECT_NEAR(s.d2[2], dz(slope_z), 1e-8);
    }
}

TEST(WaveSum, OneWaveTravelsAlongItsHeadingAtItsSpeed) {
    scene::Water water;
    water.surface.waves.waves = {
        {.length = 2, .heading = std::numbers::pi / 2, .amplitude = 0.1, .phase = 0}};
    const WaterSurface surface(water);
    const double k = std::numbers::pi;
    const double speed = angular_frequency(k, 1e4) / k;
    const double t = 0.7;
    EXPECT_NEAR(surface.sample(0.3, 0, 0).height, 0.1, 1e-15);           // a crest at the origin, along x
    EXPECT_NEAR(surface.sample(-2.2, speed * t, t).height, 0.1, 1e-15);  // has moved towards +z
}

TEST(WaveSum, BoundIsReachedAndNotPassed) {
    scene::Water water = gentle_sea();
    for (scene::Wave& wave : water.surface.waves.waves) {
        wave.phase = wave.amplitude < 0 ? std::numbers::pi : 0;
    }
    water.extent.center = {0, 0};  // vertices of an even number of cells meet the origin
    water.extent.size = {12, 12};
    const scene::WaterMesh mesh = WaterSurface(water).mesh(0);
    EXPECT_LE(mesh.largest_height, mesh.height_bound);
    EXPECT_NEAR(mesh.largest_height, mesh.height_bound, 1e-11 * mesh.height_bound);
    EXPECT_EQ(mesh.displacement_bound, 0);
}

}  // namespace
}  // namespace dapple::ocean
