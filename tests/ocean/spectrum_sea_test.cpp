#include <gtest/gtest.h>

#include <cstring>
#include <numbers>

#include "base/parallel.h"
#include "ocean/grid_mesh.h"
#include "ocean/lattice.h"
#include "ocean/reference.h"
#include "ocean/spectrum.h"
#include "ocean/water_surface.h"

namespace dapple::ocean {
namespace {

scene::Water sea() {
    scene::Water water;
    water.surface.type = scene::WaterSurfaceType::spectrum;
    scene::Spectrum& s = water.surface.spectrum;
    s.wind_heading = -0.4;
    s.depth = 2;
    s.cutoff_length = 1;
    s.seed = 7;
    water.extent.center = {-5, 11};
    water.extent.size = {14, 9};
    water.mesh_cells = 45;
    return water;
}

std::vector<ReferenceWave> references(const scene::Water& water) {
    std::vector<ReferenceWave> all;
    for (const Mode& mode : spectrum_modes(water.surface.spectrum, water.extent.size)) {
        all.push_back({mode.k.x, mode.k.y, mode.omega, std::abs(mode.amplitude), std::arg(mode.amplitude)});
    }
    return all;
}

// Bits of everything that a frame is made from.
bool same_bits(const scene::WaterMesh& a, const scene::WaterMesh& b) {
    const auto equal = [](const auto& u, const auto& v) {
        return u.size() == v.size() && std::memcmp(u.data(), v.data(), u.size() * sizeof u[0]) == 0;
    };
    return equal(a.mesh.positions, b.mesh.positions) && equal(a.mesh.normals, b.mesh.normals) &&
           equal(a.mesh.triangles, b.mesh.triangles);
}

TEST(SpectrumSea, GridEqualsTheSumOverModesInEveryField) {
    const double time = 12.5;
    // Fine, with odd sizes; and so coarse (1.4 m cells under 1 m waves) that most modes fold onto others.
    for (const int cells : {45, 10}) {
        scene::Water water = sea();
        water.mesh_cells = cells;
        const SurfaceGrid grid = WaterSurface(water).grid(time, kAllFields);
        ASSERT_EQ(grid.columns, cells + 1);
        const std::vector<ReferenceWave> waves = references(water);
        std::array<double, kFieldCount> largest{};
        for (const ReferenceWave& wave : waves) {
            for (std::size_t f = 0; f < kFieldCount; ++f) largest[f] += wave.amplitudes()[f];
        }
        for (int row = 0; row < grid.rows; row += 3) {
            for (int column = 0; column < grid.columns; column += 5) {
                const double x = grid_coordinate(-5, 14, column, grid.columns - 1);
                const double z = grid_coordinate(11, 9, row, grid.rows - 1);
                std::array<long double, kFieldCount> sum{};
                for (const ReferenceWave& wave : waves) {
                    const auto fields = wave.fields(x, z, time);
                    for (std::size_t f = 0; f < kFieldCount; ++f) sum[f] += fields[f];
                }
                const auto at = static_cast<std::size_t>(row * grid.columns + column);
                for (std::size_t f = 0; f < kFieldCount; ++f) {
                    // Phases are up to about 100 rad: 1e-14 each.
                    EXPECT_NEAR(grid.values[f][at], static_cast<double>(sum[f]), 1e-13 * largest[f])
                        << "field " << f << " row " << row << " column " << column << " of " << cells;
                }
            }
        }
    }
}

TEST(SpectrumSea, SampleEqualsTheGrid) {
    const WaterSurface surface(sea());
    const SurfaceGrid grid =
        surface.grid(2, kHeight | kSlope | kSlopeRate | kHeightRate | kSecondDerivatives);
    const int row = 17;
    const int column = 31;
    const auto at = static_cast<std::size_t>(row * grid.columns + column);
    const SurfaceSample s = surface.sample(grid_coordinate(-5, 14, column, grid.columns - 1),
                                           grid_coordinate(11, 9, row, grid.rows - 1), 2);
    // Round-off as above; values are of order 0.1 to 10.
    EXPECT_NEAR(s.height, grid[Field::height][at], 1e-12);
    EXPECT_NEAR(s.slope.x, grid[Field::slope_x][at], 1e-12);
    EXPECT_NEAR(s.slope.y, grid[Field::slope_z][at], 1e-12);
    EXPECT_NEAR(s.height_rate, grid[Field::height_rate][at], 1e-12);
    EXPECT_NEAR(s.slope_rate.x, grid[Field::slope_rate_x][at], 1e-11);
    EXPECT_NEAR(s.slope_rate.y, grid[Field::slope_rate_z][at], 1e-11);
    EXPECT_NEAR(s.d2[0], grid[Field::second_xx][at], 1e-11);
    EXPECT_NEAR(s.d2[1], grid[Field::second_xz][at], 1e-11);
    EXPECT_NEAR(s.d2[2], grid[Field::second_zz][at], 1e-11);
}

TEST(SpectrumSea, AnotherMeshIsTheSameSea) {
    scene::Water water = sea();
    water.extent.size = {12, 12};
    water.mesh_cells = 40;
    const scene::WaterMesh coarse = WaterSurface(water).mesh(1.25);
    water.mesh_cells = 80;
    const scene::WaterMesh fine = WaterSurface(water).mesh(1.25);
    for (std::size_t row = 0; row <= 40; ++row) {
        for (std::size_t column = 0; column <= 40; ++column) {
            const glm::dvec3 difference =
                coarse.mesh.positions[row * 41 + column] - fine.mesh.positions[2 * row * 81 + 2 * column];
            ASSERT_LT(glm::length(difference), 1e-13);  // round-off of two transforms of a sea of 0.1 m
        }
    }
}

TEST(SpectrumSea, RepeatsWithItsExtent) {
    const WaterSurface surface(sea());
    EXPECT_NEAR(surface.sample(-9, 8, 4).height, surface.sample(-9 + 14, 8 - 9, 4).height, 1e-12);
    const SurfaceGrid grid = surface.grid(4, kHeight);
    const auto columns = static_cast<std::size_t>(grid.columns);
    for (std::size_t row = 0; row < static_cast<std::size_t>(grid.rows); ++row) {
        EXPECT_EQ(grid[Field::height][row * columns], grid[Field::height][row * columns + columns - 1]);
    }
    const std::size_t last_row = (static_cast<std::size_t>(grid.rows) - 1) * columns;
    for (std::size_t column = 0; column < columns; ++column) {
        EXPECT_EQ(grid[Field::height][column], grid[Field::height][last_row + column]);
    }
}

TEST(SpectrumSea, SeedAndScaleMatter) {
    scene::Water water = sea();
    const double one = WaterSurface(water).sample(0, 0, 0).height;
    water.surface.spectrum.amplitude_scale = -2;
    EXPECT_NEAR(WaterSurface(water).sample(0, 0, 0).height, -2 * one, 1e-14);
    water.surface.spectrum.amplitude_scale = 1;
    water.surface.spectrum.seed = 8;
    EXPECT_NE(WaterSurface(water).sample(0, 0, 0).height, one);
}

TEST(SpectrumSea, ChoppyMeshIsDisplacedTowardsItsCrestsWithTheNormalsOfThatSurface) {
    scene::Water water = sea();
    const double choppiness = 0.6;
    water.surface.spectrum.choppiness = choppiness;
    const double time = 3;
    const scene::WaterMesh mesh = WaterSurface(water).mesh(time);
    const std::vector<ReferenceWave> waves = references(water);
    const auto point = [&](long double x, long double z) {
        std::array<long double, 3> p{x, 0, z};
        for (const ReferenceWave& wave : waves) {
            const auto fields = wave.fields(x, z, time);
            p[0] += static_cast<long double>(choppiness) *
                    fields[static_cast<std::size_t>(Field::displacement_x)];
            p[1] += fields[0];
            p[2] += static_cast<long double>(choppiness) *
                    fields[static_cast<std::size_t>(Field::displacement_z)];
        }
        return p;
    };
    const long double h = 1e-6L;  // central differences in long double: errors of 1e-11 and 1e-13
    for (int row = 0; row < mesh.rows; row += 6) {
        for (int column = 0; column < mesh.columns; column += 7) {
            const double x = grid_coordinate(-5, 14, column, mesh.columns - 1);
            const double z = grid_coordinate(11, 9, row, mesh.rows - 1);
            const auto at = static_cast<std::size_t>(row * mesh.columns + column);
            const auto p = point(x, z);
            const auto difference = [&](const auto& a, const auto& b) {
                return glm::dvec3(static_cast<double>((a[0] - b[0]) / (2 * h)),
                                  static_cast<double>((a[1] - b[1]) / (2 * h)),
                                  static_cast<double>((a[2] - b[2]) / (2 * h)));
            };
            const glm::dvec3 along_x = difference(point(x + h, z), point(x - h, z));
            const glm::dvec3 along_z = difference(point(x, z + h), point(x, z - h));
            const glm::dvec3 normal = glm::normalize(glm::cross(along_z, along_x));
            const glm::dvec3 expected(static_cast<double>(p[0]), static_cast<double>(p[1]),
                                      static_cast<double>(p[2]));
            EXPECT_LT(glm::length(mesh.mesh.positions[at] - expected), 1e-12);
            EXPECT_LT(glm::length(mesh.mesh.normals[at] - normal), 1e-9);
        }
    }
    EXPECT_EQ(mesh.folded_vertices, 0u);
    EXPECT_GT(mesh.largest_displacement, 0);
    EXPECT_LE(mesh.largest_displacement, mesh.displacement_bound);
    EXPECT_LE(mesh.largest_height, mesh.height_bound);

    // Crests are narrow and troughs wide: over the area, the mean height is below the rest plane.
    double mean = 0;  // times the area
    for (const glm::uvec3& t : mesh.mesh.triangles) {
        const glm::dvec3& a = mesh.mesh.positions[t.x];
        const glm::dvec3& b = mesh.mesh.positions[t.y];
        const glm::dvec3& c = mesh.mesh.positions[t.z];
        mean += (a.y + b.y + c.y) / 6 * glm::cross(b - a, c - a).y;
    }
    EXPECT_LT(mean / (14 * 9), -0.001);
}

TEST(SpectrumSea, FoldedVerticesAreCounted) {
    scene::Water water = sea();
    water.surface.spectrum.choppiness = 20;
    EXPECT_GT(WaterSurface(water).mesh(0).folded_vertices, 0u);
}

TEST(SpectrumSea, LoopClosesBitByBit) {
    struct Clip {
        double fps;
        int frames;
    };
    for (const Clip clip : {Clip{24, 48}, Clip{30000.0 / 1001, 70}, Clip{25, 33}}) {
        scene::Water water = sea();
        water.surface.spectrum.loop = clip.frames / clip.fps;
        water.surface.spectrum.choppiness = 0.3;
        const WaterSurface surface(water);
        for (const int frame : {0, 1, 7, clip.frames - 1}) {
            const scene::WaterMesh first = surface.mesh(frame / clip.fps);
            EXPECT_TRUE(same_bits(first, surface.mesh((frame + clip.frames) / clip.fps))) << frame;
            EXPECT_TRUE(same_bits(first, surface.mesh((frame + 9 * clip.frames) / clip.fps))) << frame;
            EXPECT_FALSE(same_bits(first, surface.mesh((frame + 1) / clip.fps))) << frame;
        }
    }
}

TEST(SpectrumSea, ThreadsDoNotChangeBits) {
    scene::Water water = sea();
    water.surface.spectrum.choppiness = 0.5;
    water.mesh_cells = 240;
    scene::Water waves = water;
    waves.surface.type = scene::WaterSurfaceType::waves;
    waves.surface.waves.waves = {{.length = 1.3, .heading = 1, .amplitude = 0.02},
                                 {.length = 0.4, .heading = 2, .amplitude = 0.01}};
    for (const scene::Water& w : {water, waves}) {
        set_thread_count(1);
        const scene::WaterMesh one = WaterSurface(w).mesh(0.7);
        set_thread_count(2);
        const scene::WaterMesh two = WaterSurface(w).mesh(0.7);
        EXPECT_TRUE(same_bits(one, two));
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace dapple::ocean
