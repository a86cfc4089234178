#include "ocean/grid_mesh.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "ocean/water_surface.h"

namespace dapple::ocean {
namespace {

scene::Water one_wave(double length) {
    scene::Water water;
    water.surface.waves.waves = {{.length = length, .heading = 0.3, .amplitude = 0.01}};
    water.extent.center = {0.1, -0.3};
    water.extent.size = {3, 2};
    return water;
}

TEST(GridMesh, FlatWaterIsExact) {
    scene::Water water = one_wave(1);
    water.surface.waves.waves[0].amplitude = 0;
    scene::Water calm = water;
    calm.surface.type = scene::WaterSurfaceType::spectrum;
    calm.surface.spectrum.amplitude_scale = 0;
    for (const scene::Water& flat : {water, calm}) {
        const scene::WaterMesh mesh = WaterSurface(flat).mesh(5);
        EXPECT_EQ(mesh.rows, 3);
        EXPECT_EQ(mesh.columns, 3);
        EXPECT_EQ(mesh.height_bound, 0);
        for (const glm::dvec3& p : mesh.mesh.positions) EXPECT_EQ(p.y, 0);
        for (const glm::dvec3& n : mesh.mesh.normals) EXPECT_EQ(n, glm::dvec3(0, 1, 0));
    }
}

TEST(GridMesh, CoversTheExtentAndFacesUp) {
    const scene::Water water = one_wave(0.2);
    const scene::WaterMesh water_mesh = WaterSurface(water).mesh(0.4);
    const scene::TriangleMesh& mesh = water_mesh.mesh;
    ASSERT_EQ(mesh.positions.size(), static_cast<std::size_t>(water_mesh.rows * water_mesh.columns));
    const glm::dvec3& first = mesh.positions.front();
    const glm::dvec3& last = mesh.positions.back();
    EXPECT_EQ(glm::dvec2(first.x, first.z), glm::dvec2(0.1 - 1.5, -0.3 - 1));
    EXPECT_EQ(glm::dvec2(last.x, last.z), glm::dvec2(0.1 + 1.5, -0.3 + 1));
    const glm::dvec3& next_row = mesh.positions[static_cast<std::size_t>(water_mesh.columns)];
    EXPECT_EQ(next_row.x, first.x);  // rows along z
    EXPECT_GT(next_row.z, first.z);
    double area = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3& a = mesh.positions[t.x];
        const double projected = 0.5 * glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a).y;
        ASSERT_GT(projected, 0);
        area += projected;
    }
    EXPECT_NEAR(area, 6, 1e-10);  // round-off of 187 500 additions, at most that many times 4e-16 each
}

TEST(GridMesh, HeightsAndNormalsAreThoseOfTheSurface) {
    const WaterSurface surface(one_wave(0.2));
    const scene::WaterMesh mesh = surface.mesh(0.4);
    for (std::size_t v = 0; v < mesh.mesh.positions.size(); v += 997) {
        const glm::dvec3& p = mesh.mesh.positions[v];
        const SurfaceSample s = surface.sample(p.x, p.z, 0.4);
        EXPECT_NEAR(p.y, s.height, 1e-15);  // round-off at 0.01 m
        EXPECT_LT(glm::length(mesh.mesh.normals[v] - glm::normalize(glm::dvec3(-s.slope.x, 1, -s.slope.y))),
                  1e-13);
    }
}

TEST(GridSize, TwentyFiveCellsAShortestWave) {
    scene::Water water = one_wave(0.2);
    water.surface.waves.waves.push_back(
        {.length = 0.1, .amplitude = 0});  // counts: its amplitude may be keyed
    const GridSize size = grid_size(water);
    EXPECT_EQ(size.cells_x, 750);
    EXPECT_EQ(size.cells_z, 500);
    EXPECT_DOUBLE_EQ(size.shortest_wave, 0.1);
    EXPECT_DOUBLE_EQ(size.cells_per_shortest_wave, 25);
    EXPECT_FALSE(size.capped);
}

TEST(GridSize, SpectrumHasSizesForItsTransform) {
    scene::Water water;
    water.surface.type = scene::WaterSurfaceType::spectrum;
    water.extent.size = {7.01, 3};
    water.surface.spectrum.cutoff_length = 0.25;  // asks for 701 by 300
    const GridSize size = grid_size(water);
    EXPECT_EQ(size.cells_x, 720);
    EXPECT_EQ(size.cells_z, 300);
    EXPECT_GE(size.cells_per_shortest_wave, 25);
    EXPECT_EQ(smooth_size_up(1025), 1080);
    EXPECT_EQ(smooth_size_down(1025), 1024);
    EXPECT_EQ(smooth_size_down(1), 1);
}

TEST(GridSize, CapIsKeptAndReported) {
    for (const bool fft : {false, true}) {
        for (const glm::dvec2 extent :
             {glm::dvec2(20, 20), glm::dvec2(100, 3), glm::dvec2(1e-3, 1e5), glm::dvec2(1e9, 1e9)}) {
            scene::Water water = one_wave(0.1);
            water.extent.size = extent;
            if (fft) {
                water.surface.type = scene::WaterSurfaceType::spectrum;
                water.surface.spectrum.cutoff_length = 0.1;
            }
            const GridSize size = grid_size(water);
            EXPECT_LE(static_cast<double>(size.triangles()), 2.1e6);
            EXPECT_TRUE(size.capped) << extent.x;
            EXPECT_LT(size.cells_per_shortest_wave, 25);
            if (extent.x == extent.y) {
                EXPECT_EQ(size.cells_x, size.cells_z);
                EXPECT_GT(static_cast<double>(size.triangles()),
                          fft ? 1.8e6 : 2.09e6);  // 1000^2: 2^a 3^b 5^c below
            }
        }
    }
}

TEST(GridSize, MeshCellsOverride) {
    scene::Water water = one_wave(0.1);
    water.mesh_cells = 30;
    GridSize size = grid_size(water);
    EXPECT_EQ(size.cells_x, 30);
    EXPECT_EQ(size.cells_z, 20);
    EXPECT_NEAR(size.cells_per_shortest_wave, 1, 1e-12);
    EXPECT_FALSE(size.capped);
    water.mesh_cells = 1 << 20;
    try {
        grid_size(water);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::timeline_invalid);
    }
}

TEST(WaterSurface, KeyTellsSurfacesApart) {
    const scene::Water water = one_wave(1);
    scene::Water other = water;
    other.refractive_index = 1.4;  // of no concern to the mesh
    EXPECT_EQ(WaterSurface::key(water), WaterSurface::key(other));
    other.surface.waves.waves[0].phase = 1e-16;
    EXPECT_NE(WaterSurface::key(water), WaterSurface::key(other));
}

}  // namespace
}  // namespace dapple::ocean
