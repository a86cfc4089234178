#include "ocean/rings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "base/hash.h"
#include "ocean/ring_checks.h"
#include "ocean/water_surface.h"
#include "ocean/wave_sum.h"

namespace dapple::ocean {
namespace {

/// Waves of 0.3 to 60 m in all directions on 400 by 300 m off the origin; cells of 3.1 cm to 1 m...
scene::Water open_sea() {
    scene::Water water;
    water.extent.center = {13, -4};
    water.extent.size = {400, 300};
    water.rings = {.inner_size = 10, .cells = 64};
    for (unsigned i = 0; i < 20; ++i) {
        scene::Wave wave;
        wave.length = 0.8 * std::pow(75.0, i / 19.0);
        wave.heading = 2 * std::numbers::pi * hash_uniform(7, 0, i, 0);
        wave.phase = 2 * std::numbers::pi * hash_uniform(7, 0, i, 1);
        wave.amplitude = 0.005 * wave.length;
        water.surface.waves.waves.push_back(wave);
    }
    return water;
}

/// Places of the camera: in the middle, anywhere, near and beyond edges of the extent, on lines of lattices.
const std::vector<glm::dvec2> kViewpoints{{13, -4},        {20.12, 31.77},  {-186.9, -153.9},
                                          {213, 146},      {150, 500},      {-5000, 2e5},
                                          {-187.3, -60.4}, {14.25, -2.125}, {1e12, 0}};

TEST(Rings, CoverTheExtentOnceWithoutCracks) {
    const scene::Water water = open_sea();
    const WaterSurface surface(water);
    for (const glm::dvec2 viewpoint : kViewpoints) {
        const scene::WaterMesh rings = surface.mesh(0.4, viewpoint);
        EXPECT_EQ(rings.rows, 0);
        expect_one_sheet(rings.mesh, water.extent, true);
    }
}

TEST(Rings, DoubleFromOneToTheNext) {
    const scene::Water water = open_sea();
    const RingLayout layout(water);
    // 10 m doubled 6 times is more than 400 m; 40 cells of 10 m and 30 across.
    ASSERT_EQ(layout.levels(), 7);
    EXPECT_EQ(layout.lattice_cells(6), glm::ivec2(40, 30));
    EXPECT_EQ(layout.cell(6), glm::dvec2(10, 10));
    const scene::WaterMesh mesh = WaterSurface(water).mesh(0, water.extent.center);
    ASSERT_EQ(mesh.rings.size(), 7u);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_DOUBLE_EQ(mesh.rings[i].cell, 0.15625 * std::exp2(i));
    for (std::size_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(mesh.rings[i].size, 10 * std::exp2(i));
    EXPECT_EQ(mesh.rings[6].size, 400);
    EXPECT_NEAR(mesh.cells_per_shortest_wave, 0.8 / 0.15625, 1e-12);
}

TEST(Rings, TrianglesAreAsManyAsTheFormulaSays) {
    scene::Water water = open_sea();
    water.extent.size = {400, 400};
    const RingLayout layout(water);
    const WaterSurface surface(water);
    // Two a cell, and one more for each cell along a hole, whose 4 sides are 32 cells each.
    const std::size_t square = 64 * 64, hole = 32 * 32, ring = 2 * (square - hole) + 4 * 32;
    const std::size_t expected = 2 * square + 5 * ring + 2 * (40 * 40 - hole) + 4 * 32;
    EXPECT_EQ(surface.mesh(0, water.extent.center).mesh.triangles.size(), expected);
    const MeshCounts most = mesh_counts(water);
    EXPECT_EQ(most.triangles, layout.most().triangles);
    for (const glm::dvec2 viewpoint : kViewpoints) {
        const scene::WaterMesh mesh = surface.mesh(0, viewpoint);
        EXPECT_LE(mesh.mesh.triangles.size(), most.triangles);
        EXPECT_LE(mesh.mesh.positions.size(), most.vertices);
    }
    EXPECT_LT(static_cast<double>(most.triangles), 1.1 * static_cast<double>(expected));
    // Far from the water the last level is all there is.
    EXPECT_EQ(surface.mesh(0, {1e12, 0}).mesh.triangles.size(), 2 * 40 * 40);
}

TEST(Rings, HeightsAndNormalsAreThoseOfTheWavesThatTheyHave) {
    const scene::Water water = open_sea();
    const RingLayout layout(water);
    const WaterSurface surface(water);
    const glm::dvec2 viewpoint(20.12, 31.77);
    const scene::WaterMesh rings = surface.mesh(3, viewpoint);
    std::array<int, 7> checked{};
    for (std::size_t v = 0; v < rings.mesh.positions.size(); ++v) {
        const glm::dvec3& p = rings.mesh.positions[v];
        const glm::dvec2 offset = glm::dvec2(p.x, p.z) - viewpoint;
        const int level = finest_level(layout, water.extent, viewpoint, glm::dvec2(p.x, p.z));
        if (layout.morph(level, offset) != 0) continue;
        scene::Water kept = water;
        std::erase_if(kept.surface.waves.waves, [&](const scene::Wave& wave) {
            return level > 0 && wave.length < 4 * layout.cell(level).x;
        });
        const SurfaceSample s = WaveSum(kept.surface.waves).sample(p.x, p.z, 3);
        // Phases are up to 1600 rad, rounded by 2e-13, of waves of up to 0.3 m.
        ASSERT_NEAR(p.y, s.height, 1e-12);
        ASSERT_LT(glm::length(rings.mesh.normals[v] - glm::normalize(glm::dvec3(-s.slope.x, 1, -s.slope.y))),
                  1e-12);
        ++checked[static_cast<std::size_t>(level)];
    }
    // More than half of the square of 3/4, less its hole.
    for (std::size_t level = 0; level < 7; ++level) EXPECT_GT(checked[level], 300) << level;
    EXPECT_LE(rings.largest_height, rings.height_bound);
}

TEST(Rings, NothingPopsWhenTheCameraMoves) {
    const scene::Water water = open_sea();
    const WaterSurface surface(water);
    const RingLayout layout(water);
    // A millimetre along both axes, where no level moves, and where the first 1, 2, ... 6 do: half-way
    // between lines of level n + 1 and so of none coarser; and on a line of level 6.
    const double step = 1e-3;
    const glm::dvec2 corner = water.extent.center - 0.5 * water.extent.size;
    std::vector<glm::dvec2> places{{20.12, 31.77}};
    for (int level = 1; level < 7; ++level)
        places.push_back(corner +
                         layout.cell(level) * (glm::floor(glm::dvec2(210, 150) / layout.cell(level)) + 0.5));
    std::size_t moved = 0;
    for (const glm::dvec2 place : places) {
        const scene::WaterMesh before = surface.mesh(3, place - 0.5 * step),
                               after = surface.mesh(3, place + 0.5 * step);
        moved += before.mesh.positions != after.mesh.positions;
        const HeightField first(before.mesh), second(after.mesh);
        for (unsigned i = 0; i < 100; ++i) {
            // As many in each ring.
            const double reach = 4 * std::pow(40.0, hash_uniform(2, 0, i, 2));
            const glm::dvec2 at = glm::clamp(
                place + reach * (2.0 * glm::dvec2(hash_uniform(2, 0, i, 0), hash_uniform(2, 0, i, 1)) - 1.0),
                corner + 1e-6, corner + water.extent.size - 1e-6);
            glm::dvec2 slope_before(0), slope_after(0);
            const double change = second.at(at, &slope_after) - first.at(at, &slope_before);
            // A weight changes by 1.5 steps over the width of its ramp, 4 cells of 16 cm or more, times what
            // it weighs: waves with fewer than 8 cells (their amplitudes, at most 4 in an octave; 0.5 % of at
            // most 8 cells each) and the chord's distance from the rest, at most of the order of the same.
            const double weight = 1.5 * step / (4 * 0.15625);
            const double amplitude = 4 * 0.005 * 8 * 0.15625;
            ASSERT_LT(std::abs(change), 2 * weight * amplitude) << at.x << ' ' << at.y;
            // Slopes: a wave's is 2 pi times 0.5 %.
            ASSERT_LT(glm::length(slope_after - slope_before), 2 * weight * 4 * 2 * std::numbers::pi * 0.005);
        }
    }
    EXPECT_EQ(moved, places.size()) << "else nothing was tried";
}

TEST(Rings, SayWhatSlopeTheyLeaveOut) {
    scene::Water water = open_sea();
    // Cells of 0.15625 m: 4 of them, but not 8, and 64, but not 128.
    water.surface.waves.waves = {{.length = 1.2, .amplitude = 0.012}, {.length = 15, .amplitude = 0.15}};
    const scene::WaterMesh mesh = WaterSurface(water).mesh(0, {13, -4});
    // Equal shares: (k a)^2 / 2.
    const std::array<double, 7> expected{0.5, 0.5, 0.5, 0.5, 1, 1, 1};
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(mesh.rings[i].slope_left_out, expected[i], 1e-12) << i;
    EXPECT_EQ(mesh.height_bound, 0.162 * (1 + 1e-12));
}

TEST(Rings, FlatWaterIsExact) {
    scene::Water water = open_sea();
    for (scene::Wave& wave : water.surface.waves.waves) wave.amplitude = 0;
    const scene::WaterMesh mesh = WaterSurface(water).mesh(1, {2, 3});
    for (const glm::dvec3& p : mesh.mesh.positions) ASSERT_EQ(p.y, 0);
    for (const glm::dvec3& n : mesh.mesh.normals) ASSERT_EQ(n, glm::dvec3(0, 1, 0));
    EXPECT_EQ(mesh.cells_per_shortest_wave, 0);
}

TEST(Rings, WhatTheyCannotServeIsRefused) {
    scene::Water water = open_sea();
    EXPECT_NE(WaterSurface::key(water), WaterSurface::key([&] {
                  scene::Water other = water;
                  other.rings.cells = 68;
                  return other;
              }()));
    water.rings.inner_size = 1e-9;
    EXPECT_THROW(WaterSurface{water}, Error);
    water = open_sea();
    water.rings = {.inner_size = 400, .cells = 8192};
    EXPECT_THROW(WaterSurface{water}, Error);
}

}  // namespace
}  // namespace dapple::ocean
