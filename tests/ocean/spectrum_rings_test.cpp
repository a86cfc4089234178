// A JONSWAP sea that repeats within its extent, on a regular grid and on nested rings about the camera.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "ocean/reference.h"
#include "ocean/ring_checks.h"
#include "ocean/rings.h"
#include "ocean/spectrum.h"
#include "ocean/water_surface.h"

namespace dapple::ocean {
namespace {

/// A sea of 320 by 240 m off the origin that repeats after 40 m, of waves down to 1 m; rings of cells of at
/// most 15.6 cm.
scene::Water open_sea() {
    scene::Water water;
    water.extent.center = {13, -4};
    water.extent.size = {320, 240};
    water.rings = {.inner_size = 10, .cells = 64};
    water.surface.type = scene::WaterSurfaceType::spectrum;
    scene::Spectrum& s = water.surface.spectrum;
    s.wind_heading = 0.7;
    s.cutoff_length = 1;
    s.period = 41;
    s.seed = 5;
    return water;
}

const std::vector<glm::dvec2> kViewpoints{{13, -4}, {20.12, 31.77}, {-146.9, -123.9}, {1e12, 0}};

/// The modes that are as long or longer.
std::vector<ReferenceWave> waves_from(const scene::Water& water, double least) {
    std::vector<ReferenceWave> all;
    for (const Mode& mode :
         spectrum_modes(water.surface.spectrum, water.extent.size / glm::dvec2(periods_across(water)))) {
        if (2 * std::numbers::pi / glm::length(mode.k) >= least)
            all.push_back(
                {mode.k.x, mode.k.y, mode.omega, std::abs(mode.amplitude), std::arg(mode.amplitude)});
    }
    return all;
}

std::array<double, kFieldCount> sum_at(const std::vector<ReferenceWave>& waves, glm::dvec2 place,
                                       double time) {
    std::array<long double, kFieldCount> sum{};
    for (const ReferenceWave& wave : waves) {
        const auto fields = wave.fields(place.x, place.y, time);
        for (std::size_t f = 0; f < kFieldCount; ++f) sum[f] += fields[f];
    }
    std::array<double, kFieldCount> rounded{};
    for (std::size_t f = 0; f < kFieldCount; ++f) rounded[f] = static_cast<double>(sum[f]);
    return rounded;
}

bool same_bits(const scene::WaterMesh& a, const scene::WaterMesh& b) {
    const auto equal = [](const auto& u, const auto& v) {
        return u.size() == v.size() && std::memcmp(u.data(), v.data(), u.size() * sizeof u[0]) == 0;
    };
    return equal(a.mesh.positions, b.mesh.positions) && equal(a.mesh.normals, b.mesh.normals) &&
           equal(a.mesh.triangles, b.mesh.triangles);
}

TEST(SpectrumPeriod, IsRoundedToWholeOnesOfTheExtent) {
    scene::Water water = open_sea();
    EXPECT_EQ(periods_across(water), glm::ivec2(8, 6));  // 40 m
    water.surface.spectrum.period = 0;
    EXPECT_EQ(periods_across(water), glm::ivec2(1, 1));
    water.surface.spectrum.period = 1e5;
    EXPECT_EQ(periods_across(water), glm::ivec2(1, 1));
    EXPECT_NE(WaterSurface::key(water), WaterSurface::key(open_sea()));
    water.surface.spectrum.period = 1e-9;
    EXPECT_THROW(periods_across(water), Error);
}

TEST(SpectrumPeriod, OfARegularGridRepeatsTheDirectSum) {
    scene::Water water = open_sea();
    water.rings = {};
    water.mesh_cells = 310;
    const WaterSurface surface(water);
    // 310 cells are 39 in a period of 8, which 40 is the next size for of the transform.
    ASSERT_EQ(surface.size().cells_x, 8 * 40);
    ASSERT_EQ(surface.size().cells_z, 6 * 40);
    const SurfaceGrid grid = surface.grid(3, kAllFields);
    const std::vector<ReferenceWave> waves = waves_from(water, 0);
    std::array<double, kFieldCount> largest{};
    for (const ReferenceWave& wave : waves) {
        for (std::size_t f = 0; f < kFieldCount; ++f) largest[f] += wave.amplitudes()[f];
    }
    for (int row = 0; row <= 240; row += 40) {
        for (int column = 7; column <= 320; column += 53) {
            const glm::dvec2 place(grid_coordinate(13, 320, column, 320), grid_coordinate(-4, 240, row, 240));
            const std::array<double, kFieldCount> sum = sum_at(waves, place, 3);
            const auto at = static_cast<std::size_t>(row * grid.columns + column);
            // Phases are up to 1000 rad, rounded by 1e-13.
            for (std::size_t f = 0; f < kFieldCount; ++f)
                EXPECT_NEAR(grid.values[f][at], sum[f], 1e-12 * largest[f]) << f;
            const auto period_on = static_cast<std::size_t>(row * grid.columns + (column + 40) % 320);
            EXPECT_EQ(grid[Field::height][at], grid[Field::height][period_on]);
        }
    }
    const SurfaceSample s = surface.sample(20, 5, 3);
    EXPECT_NEAR(s.height, surface.sample(20 + 40, 5 - 80, 3).height, 1e-12);
    // The cap of triangles keeps to whole periods.
    water.mesh_cells = 0;
    const GridSize size = WaterSurface(water).size();
    EXPECT_TRUE(size.capped);
    EXPECT_EQ(glm::ivec2(size.cells_x, size.cells_z) % glm::ivec2(8, 6), glm::ivec2(0));
}

TEST(SpectrumRings, CoverTheExtentOnceWithoutCracks) {
    for (const double choppiness : {0.0, 0.4}) {
        scene::Water water = open_sea();
        water.surface.spectrum.choppiness = choppiness;
        const WaterSurface surface(water);
        for (const glm::dvec2 viewpoint : kViewpoints) {
            const scene::WaterMesh rings = surface.mesh(0.4, viewpoint);
            EXPECT_EQ(rings.folded_vertices, 0u);
            expect_one_sheet(rings.mesh, water.extent, choppiness == 0);
            EXPECT_LE(rings.largest_height, rings.height_bound);
            EXPECT_LE(rings.largest_displacement, rings.displacement_bound);
            EXPECT_EQ(rings.largest_displacement > 0, choppiness > 0);
        }
    }
}

TEST(SpectrumRings, VerticesAreThoseOfTheDirectSum) {
    scene::Water water = open_sea();
    const RingLayout layout(water);
    const glm::dvec2 viewpoint(20.12, 31.77);
    const scene::WaterMesh flat = WaterSurface(water).mesh(3, viewpoint);
    const double choppiness = 0.4;
    water.surface.spectrum.choppiness = choppiness;
    const scene::WaterMesh choppy = WaterSurface(water).mesh(3, viewpoint);
    std::vector<std::vector<ReferenceWave>> waves;
    for (int level = 0; level < layout.levels(); ++level) {
        const glm::dvec2 cell = layout.cell(level);
        waves.push_back(waves_from(water, level == 0 ? 0 : 4 * std::max(cell.x, cell.y)));
    }
    std::vector<int> checked(waves.size());
    for (std::size_t v = 0; v < flat.mesh.positions.size(); v += 17) {
        const glm::dvec3& p = flat.mesh.positions[v];
        const glm::dvec2 place(p.x, p.z);
        const int level = finest_level(layout, water.extent, viewpoint, place);
        if (layout.morph(level, place - viewpoint) != 0) continue;
        const auto sum = sum_at(waves[static_cast<std::size_t>(level)], place, 3);
        const auto of = [&](Field field) { return sum[static_cast<std::size_t>(field)]; };
        // Phases are up to 1300 rad, rounded by 2e-13, of waves that sum up to 0.5 m and slopes of 1.
        ASSERT_NEAR(p.y, of(Field::height), 1e-12);
        const glm::dvec3 normal = glm::normalize(glm::dvec3(-of(Field::slope_x), 1, -of(Field::slope_z)));
        ASSERT_LT(glm::length(flat.mesh.normals[v] - normal), 1e-11);
        const glm::dvec3 displaced =
            p + choppiness * glm::dvec3(of(Field::displacement_x), 0, of(Field::displacement_z));
        ASSERT_LT(glm::length(choppy.mesh.positions[v] - displaced), 2e-12);
        ++checked[static_cast<std::size_t>(level)];
    }
    for (std::size_t level = 0; level < waves.size(); ++level) EXPECT_GT(checked[level], 20) << level;
    // Waves of 4 cells and more are there on all levels but those that are too coarse for any.
    EXPECT_GT(waves[3].size(), 100u);
}

TEST(SpectrumRings, StayWhereTheyAreWhenTheCameraMoves) {
    const scene::Water water = open_sea();
    const WaterSurface surface(water);
    const RingLayout layout(water);
    const glm::dvec2 corner = water.extent.center - 0.5 * water.extent.size, step(1e-3);
    std::vector<glm::dvec2> places{{20.12, 31.77}};
    // Half-way between lines of level n + 1, where the first n + 1 levels move on.
    for (int level = 1; level < layout.levels(); ++level)
        places.push_back(corner +
                         layout.cell(level) * (glm::floor(glm::dvec2(170, 120) / layout.cell(level)) + 0.5));
    double variance = 0;
    for (const ReferenceWave& wave : waves_from(water, 0)) variance += 0.5 * wave.amplitude * wave.amplitude;
    for (const glm::dvec2 place : places) {
        const scene::WaterMesh before = surface.mesh(3, place - 0.5 * step),
                               after = surface.mesh(3, place + 0.5 * step);
        // Where levels do not move the same vertices are moved by the change of their weights alone.
        if (place == places[0]) {
            ASSERT_EQ(before.mesh.triangles, after.mesh.triangles);
            for (std::size_t v = 0; v < before.mesh.positions.size(); ++v) {
                const glm::dvec3 &a = before.mesh.positions[v], &b = after.mesh.positions[v];
                ASSERT_EQ(glm::dvec2(a.x, a.z), glm::dvec2(b.x, b.z));
                const glm::dvec2 at(a.x, a.z);
                const int level = finest_level(layout, water.extent, place, at);
                if (layout.morph(level, at - place - step) == 0 &&
                    layout.morph(level, at - place + step) == 0) {
                    ASSERT_EQ(a.y, b.y);
                }
            }
        }
        const HeightField first(before.mesh), second(after.mesh);
        for (unsigned i = 0; i < 60; ++i) {
            const double reach = 4 * std::pow(30.0, hash_uniform(2, 0, i, 2));
            const glm::dvec2 at = glm::clamp(
                place + reach * (2.0 * glm::dvec2(hash_uniform(2, 0, i, 0), hash_uniform(2, 0, i, 1)) - 1.0),
                corner + 1e-6, corner + water.extent.size - 1e-6);
            // A weight changes by 1.5 steps over the width of its ramp, 4 cells or more, times what goes and
            // how far chords are off the rest: the sea's height at most, of which 6 times its deviation is
            // never passed here.
            const double weight = 1.5 * step.x / (4 * layout.cell(0).x);
            ASSERT_LT(std::abs(second.at(at) - first.at(at)), 2 * weight * 6 * std::sqrt(variance));
        }
    }
}

TEST(SpectrumRings, ThreadsDoNotChangeBits) {
    scene::Water water = open_sea();
    water.surface.spectrum.choppiness = 0.4;
    set_thread_count(1);
    const scene::WaterMesh one = WaterSurface(water).mesh(0.7, {20, 30});
    set_thread_count(2);
    const scene::WaterMesh two = WaterSurface(water).mesh(0.7, {20, 30});
    set_thread_count(0);
    EXPECT_TRUE(same_bits(one, two));
}

TEST(SpectrumRings, LayoutsServeAnyPeriod) {
    for (const double period : {0.0, 17.0, 33.3, 40.0, 99.0, 250.0}) {
        for (const glm::dvec2 size : {glm::dvec2(320, 240), glm::dvec2(1000, 997), glm::dvec2(900, 31)}) {
            for (const double inner : {8.0, 30.0, 60.0}) {
                if (period == 0 && size.y > 900 && inner < 30) continue;  // too many points
                scene::Water water = open_sea();
                water.extent.size = size;
                water.surface.spectrum.period = period;
                water.rings = {.inner_size = inner, .cells = 96};
                const RingLayout layout(water);
                const glm::ivec2 periods = periods_across(water);
                const glm::dvec2 cell = layout.cell(0);
                EXPECT_LE(std::max(cell.x, cell.y), inner / 96 * (1 + 1e-8));
                EXPECT_GE(layout.across() * std::min(cell.x, cell.y), inner * (1 - 1e-8));
                for (int level = 0; level < layout.levels(); ++level) {
                    const glm::ivec2 cells = layout.lattice_cells(level);
                    if (std::isinf(layout.lasting_waves(level - 1).least)) {
                        // Then the longest modes have fewer than 4 cells along one side.
                        const glm::dvec2 of_period = glm::dvec2(cells) / glm::dvec2(periods);
                        EXPECT_LT(std::min(of_period.x, of_period.y), 4);
                    } else {
                        EXPECT_EQ(cells % periods, glm::ivec2(0));
                        const glm::ivec2 points = cells / periods;
                        EXPECT_EQ(smooth_size_up(points.x), points.x);
                        EXPECT_EQ(smooth_size_up(points.y), points.y);
                    }
                }
            }
        }
    }
}

TEST(SpectrumRings, TenKilometresAreServedAndForeseen) {
    scene::Water water = open_sea();
    water.extent = {scene::ExtentKind::open_water, {0, 0}, {1e4, 1e4}};
    water.surface.spectrum.period = 100;
    water.rings = {.inner_size = 20, .cells = 128};
    const MeshCounts most = mesh_counts(water);
    const RingLayout layout(water);
    const scene::WaterMesh mesh = WaterSurface(water).mesh(1, {12.3, -45.6});
    EXPECT_LE(mesh.mesh.positions.size(), most.vertices);
    EXPECT_LE(mesh.mesh.triangles.size(), most.triangles);
    EXPECT_LT(most.triangles, 1'500'000u);
    // 31 000 modes; 640 by 640 points or a few more of three fields and two complex spectra.
    EXPECT_GT(most.spectrum_bytes, 640u * 640u * 56u);
    EXPECT_LT(most.spectrum_bytes, 640u * 640u * 56u * 3 / 2 + 31'000u * 150u);
    EXPECT_EQ(mesh.rings.back().size, 1e4);
    EXPECT_EQ(mesh.rings.back().slope_left_out, 1);
    EXPECT_LT(mesh.rings.front().slope_left_out, 0.2);
}

TEST(SpectrumRings, FlatSeasAreFlat) {
    scene::Water water = open_sea();
    water.surface.spectrum.amplitude_scale = 0;
    water.surface.spectrum.period = 0;
    water.extent.size = {1e5, 1e5};
    const scene::WaterMesh mesh = WaterSurface(water).mesh(1, {2, 3});
    for (const glm::dvec3& p : mesh.mesh.positions) ASSERT_EQ(p.y, 0);
}

TEST(SpectrumRings, WhatTheyCannotServeIsRefused) {
    const auto message = [](const scene::Water& water) {
        try {
            WaterSurface{water};
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    scene::Water water = open_sea();
    water.surface.spectrum.period = 0;
    water.extent.size = {1e4, 1e4};
    EXPECT_NE(message(water).find("water.surface.period"), std::string::npos) << message(water);
    // 9999 times: the coarsest ring has a cell in each.
    water.surface.spectrum.period = 1.0001;
    EXPECT_NE(message(water).find("water.surface.period"), std::string::npos) << message(water);
    water.surface.spectrum.period = 1;
    EXPECT_EQ(message(water), "");
}

}  // namespace
}  // namespace dapple::ocean
