// Hard cases of light: what the water passes is caught by planes around the scene, or lost by a name.
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.h"
#include "hard_cases/hard_case.h"
#include "image/temporary_folder.h"

namespace dapple {
namespace {

using light::Event;
using test::CaughtLight;

constexpr double kIndex = 1.333;

/// |caught + lost - sent| within 1 % of what was sent.
void expect_balance(const char* what, double caught, double lost, double sent) {
    printf("%s: sent %.4g W, caught %.4g W, lost by name %.4g W, without a name %+.2e\n", what, sent, caught,
           lost, (sent - caught - lost) / sent);
    EXPECT_NEAR(caught + lost, sent, 0.01 * sent) << what;
}

class LowSun : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Elevation, LowSun, testing::Values(0.1, 0.5, 1.0, 5.0));

TEST_P(LowSun, OverWavesThatShadowEachOther) {
    scene::FrameState state = test::clear_sea(3, 90 - GetParam(), 240);
    state.water->surface.waves.waves = {test::wave(1, 10, 0.03), test::wave(0.6, 60, 0.012, 1),
                                        test::wave(0.45, -50, 0.008, 2)};
    const CaughtLight passed(state, Event::transmission);
    const test::SunOnMesh sun =
        test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
    // Triangles by their own planes against the mean of their corners' Fresnel: 0.2 % at this mesh.
    expect_balance("low sun, passed", passed.on(test::inside_of_box({-20, -2, -20}, {20, 2, 20})),
                   passed.lost(), sun.passed);
    EXPECT_GT(passed.lost("lost to wave shadow, W"), GetParam() < 2 ? 0.1 * sun.passed : 0);
    const CaughtLight mirrored(state, Event::reflection);
    expect_balance("low sun, mirrored", mirrored.on(test::inside_of_box({-20, -2, -20}, {20, 8, 20})),
                   mirrored.lost(), sun.met - sun.passed);
}

TEST(OverturningWater, KeepsItsLightOnBothSides) {
    scene::FrameState state = test::clear_sea(6, 40, 0);
    state.water->surface.type = scene::WaterSurfaceType::spectrum;
    scene::Spectrum& sea = state.water->surface.spectrum;
    sea.wind_speed = 5;
    sea.fetch = 500;
    sea.cutoff_length = 0.5;
    sea.choppiness = 4;
    sea.amplitude_scale = 3;
    const CaughtLight passed(state, Event::transmission), mirrored(state, Event::reflection);
    const scene::WaterMesh& water = *passed.scene().water;
    printf("%zu of %zu vertices folded\n", water.folded_vertices, water.mesh.positions.size());
    ASSERT_GT(water.folded_vertices, 0u);
    const test::SunOnMesh sun = test::sun_on_mesh(water.mesh, state.lights[0].direction, kIndex);
    const auto box = test::inside_of_box({-20, -6, -20}, {20, 6, 20});
    const double passed_on = passed.on(box), mirrored_on = mirrored.on(box);
    // Folded edges have no one normal: Fresnel of corners and of planes differ there, their sum does not.
    expect_balance("overturning", passed_on + mirrored_on, passed.lost() + mirrored.lost(), sun.met);
    expect_balance("overturning, beams passed", passed_on, 0, passed.carried());
    expect_balance("overturning, beams mirrored", mirrored_on, 0, mirrored.carried());
    EXPECT_GT(passed.lost("lost to wave shadow, W"), 0);
}

TEST(TotalReflection, FromBelowIsCounted) {
    scene::FrameState state = test::clear_sea(6, 0, 240);
    state.water->surface.waves.waves = {test::wave(1, 10, 0.01), test::wave(0.6, 60, 0.005, 1)};
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.2, -1, 0.1};
    lamp.intensity = glm::dvec3(1);
    state.lights = {lamp};
    const CaughtLight passed(state, Event::transmission), mirrored(state, Event::reflection);
    // Solid angle of the patch seen from 1 m below its middle: 4 asin of the product of half-angles' sines,
    // by quarters, each a corner rectangle: atan(a b / (d sqrt(a^2 + b^2 + d^2))). The waves change it by
    // (amplitude / distance) at the border only.
    double solid = 0;
    for (const double a : {2.8, 3.2})
        for (const double b : {2.9, 3.1}) solid += std::atan(a * b / std::sqrt(a * a + b * b + 1));
    const double up = passed.on(test::inside_of_box({-12, -2, -12}, {12, 3, 12}), 64);
    const double down = mirrored.on(test::inside_of_box({-12, -3, -12}, {12, 2, 12}), 64);
    expect_balance("lamp below", up + down, passed.lost() + mirrored.lost(), solid);
    // What a triangle across the critical angle would have passed; none beyond it passes anything.
    EXPECT_GT(passed.lost("lost to total reflection, W"), 0);
    EXPECT_LT(passed.lost("lost to total reflection, W"), 0.01 * solid);
    EXPECT_GT(mirrored.carried(), passed.carried());
}

TEST(Cusp, OnTheFloorKeepsItsFlux) {
    // Parallel rays through a crest of a k^2 = n / ((n - 1) f): the cusp of its caustic lies f below it.
    for (const double depth : {1.0, 2.0, 4.0}) {
        scene::FrameState state = test::clear_sea(4, 0, 400);
        const double k = glm::two_pi<double>();
        state.water->surface.waves.waves = {test::wave(1, 0, kIndex / ((kIndex - 1) * 2 * k * k), 0.4)};
        const CaughtLight passed(state, Event::transmission);
        const test::SunOnMesh sun =
            test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
        expect_balance("cusp", passed.on({{{-4, -depth, -4}, {8, 0, 0}, {0, 0, 8}}}, 256), passed.lost(),
                       sun.passed);
    }
}

/// Writes an ASCII PLY file of triangles.
void write_ply(const std::string& path, const std::vector<glm::dvec3>& positions,
               const std::vector<glm::uvec3>& triangles) {
    std::ofstream file(path);
    file.precision(17);
    file << "ply\nformat ascii 1.0\nelement vertex " << positions.size()
         << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << triangles.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const glm::dvec3& p : positions) file << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (const glm::uvec3& t : triangles) file << "3 " << t.x << ' ' << t.y << ' ' << t.z << '\n';
}

void use_file(scene::FrameState& state, const std::string& pattern) {
    state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
    state.water->surface.mesh_sequence.pattern = pattern;
}

TEST(Focus, HoldsAllFluxInOnePixel) {
    // Rays straight down meet the point at depth D from a surface of which all optical ways are equal: at the
    // angle t seen from there it is n - 1 over n - cos t of D away (Descartes' ellipsoid).
    constexpr double kDepth = 2;
    constexpr int kRings = 120, kSpokes = 240;
    std::vector<glm::dvec3> positions{{0, 0, 0}};
    std::vector<glm::uvec3> triangles;
    for (int ring = 1; ring <= kRings; ++ring) {
        const double t = glm::radians(15.0) * ring / kRings;
        const double r = kDepth * (kIndex - 1) / (kIndex - std::cos(t));
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            const double around = glm::two_pi<double>() * spoke / kSpokes;
            positions.emplace_back(r * std::sin(t) * std::cos(around), r * std::cos(t) - kDepth,
                                   r * std::sin(t) * std::sin(around));
        }
    }
    const auto at = [](int ring, int spoke) {
        return ring == 0 ? 0u : static_cast<std::uint32_t>(1 + (ring - 1) * kSpokes + spoke % kSpokes);
    };
    for (int ring = 0; ring < kRings; ++ring)
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
            triangles.emplace_back(at(ring, spoke), at(ring + 1, spoke + 1), at(ring + 1, spoke));
            if (ring > 0)
                triangles.emplace_back(at(ring, spoke), at(ring, spoke + 1), at(ring + 1, spoke + 1));
        }
    const test::TemporaryFolder folder;
    write_ply(folder / "lens.0001.ply", positions, triangles);
    scene::FrameState state = test::clear_sea(2, 0, 0);
    use_file(state, folder / "lens.%04d.ply");
    const CaughtLight passed(state, Event::transmission);
    const test::SunOnMesh sun =
        test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
    // One of 64 x 64 receivers, 5 cm wide, in whose middle the focus is. The file's normals are means over
    // triangles, by which the outermost ring's rays miss by the slope of half a ring: 1.7 % of the light.
    const double pixel = 0.05;
    const double in_pixel =
        passed.on({{{-4 * pixel, -kDepth, -4 * pixel}, {8 * pixel, 0, 0}, {0, 0, 8 * pixel}}}, 8);
    expect_balance("perfect focus, floor", passed.on({{{-2, -kDepth, -2}, {4, 0, 0}, {0, 0, 4}}}),
                   passed.lost(), sun.passed);
    EXPECT_GT(in_pixel, 0.95 * sun.passed);
}

TEST(BrokenMeshes, LoseOnlyTheirBrokenTriangles) {
    // A gentle sea of 40 x 40 cells, with a triangle of no area, one given twice, and a vertex that is no
    // number.
    constexpr int kCells = 40;
    std::vector<glm::dvec3> positions;
    std::vector<glm::uvec3> triangles;
    for (int j = 0; j <= kCells; ++j)
        for (int i = 0; i <= kCells; ++i)
            positions.emplace_back(0.1 * i - 2, 0.01 * std::sin(0.7 * i + 0.3 * j), 0.1 * j - 2);
    for (int j = 0; j < kCells; ++j)
        for (int i = 0; i < kCells; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (kCells + 1) + i), b = a + kCells + 1;
            triangles.emplace_back(a, b, b + 1);
            triangles.emplace_back(a, b + 1, a + 1);
        }
    triangles.emplace_back(500, 501, 501);
    triangles.emplace_back(300, 300, 300);
    triangles.push_back(triangles[900]);
    const test::TemporaryFolder folder;
    scene::FrameState state = test::clear_sea(4, 30, 0);
    use_file(state, folder / "broken.%04d.ply");
    const auto box = test::inside_of_box({-10, -4, -10}, {10, 4, 10});
    {
        write_ply(folder / "broken.0001.ply", positions, triangles);
        const CaughtLight passed(state, Event::transmission);
        const test::SunOnMesh sun =
            test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
        expect_balance("broken mesh", passed.on(box), passed.lost(), sun.passed);
    }
    positions[800].y = std::nan("");
    write_ply(folder / "broken.0001.ply", positions, triangles);
    try {
        const CaughtLight passed(state, Event::transmission);
        const test::SunOnMesh sun =
            test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
        expect_balance("mesh with NaN", passed.on(box), passed.lost(), sun.passed);
        EXPECT_GT(passed.lost("facets not finite"), 0);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable) << error.what();
        printf("mesh with NaN: %s\n", error.what());
    }
}

TEST(SetSun, SendsNothing) {
    scene::FrameState state = test::clear_sea(4, 100, 20);
    for (const Event event : {Event::transmission, Event::reflection}) {
        const CaughtLight light(state, event);
        EXPECT_EQ(light.carried(), 0);
        EXPECT_EQ(light.on(test::inside_of_box({-10, -4, -10}, {10, 4, 10})), 0);
    }
}

/// Under a trough in the middle of a column of cells rays part to both sides, those of each beam too. A wall
/// that runs within that column meets some of the rays of these beams, and of no others.
TEST(Walls, WhatTheyMissOfBeamsThatPartIsCounted) {
    constexpr double kCell = 0.1, kTop = 0.1, kFloor = 4;
    scene::FrameState state = test::clear_sea(6, 0, 60);
    const double k = glm::two_pi<double>() / 1.6;
    state.water->surface.waves.waves = {test::wave(1.6, 0, 0.08, glm::pi<double>() - k * kCell / 2)};
    const CaughtLight passed(state, Event::transmission);
    // Across the column at a small angle, so that it lies anywhere within the parts that beams are counted
    // by.
    const glm::dvec3 from(0.6 * kCell, 0, -1), along(0.35 * kCell, 0, 2), down(0, -1, 0);
    // What comes to lie beyond the wall from one level to another has crossed it from its front.
    const auto beyond = [&](double depth) { return passed.on({from + depth * down, {5, 0, 0}, along}, 128); };
    const double crossing = beyond(kFloor) - beyond(kTop);
    EXPECT_EQ(passed.parted(), 0) << "no ray meets a level plane from below";
    const glm::dvec3 height = (kTop - kFloor) * down;
    const double front = passed.on({from + kFloor * down, height, along}, 128);
    const double missed = passed.parted();
    const double back = passed.on({from + kFloor * down, along, height}, 128);
    printf("parted beams: %.4g W cross, %.4g W missed\n", crossing, missed);
    EXPECT_EQ(front, 0);
    EXPECT_EQ(back, 0);
    // Each of 40 beams is counted by 16 parts, of which a seventh land on the wall.
    EXPECT_NEAR(missed, crossing, 0.05 * crossing);
    EXPECT_EQ(passed.parted(), missed) << "no ray meets the back";
}

/// Light of flat water on slopes: E of a plane is level E times the way's cosine to it over that to the
/// level.
TEST(Shore, CatchesTheLightUpToTheWaterLine) {
    for (const double slope_degrees : {2.0, 10.0, 30.0}) {
        scene::FrameState state = test::clear_sea(4, 30, 200);
        const CaughtLight passed(state, Event::transmission);
        // The bed rises along +x and meets the rest plane at x = 0.5. All that enters before that line lands
        // on it; the patch's light is sun.passed / 4 m a metre of x. The part that starts in the first metre
        // is caught to the side of it, still on the plane.
        const double slope = glm::radians(slope_degrees);
        const glm::dvec3 along(std::cos(slope), std::sin(slope), 0);
        const test::SunOnMesh sun =
            test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
        const double reach = 6;
        const double caught =
            passed.on({glm::dvec3(0.5, 0, -4) - reach * along, 2 * reach * along, {0, 0, 8}}, 256);
        expect_balance("shore", caught, 0, sun.passed * 2.5 / 4);
        // The last two centimetres before the water line hold no more and no less than their share.
        const double thin = passed.on({glm::dvec3(0.5, 0, -1) - 0.02 * along, 0.04 * along, {0, 0, 2}}, 8);
        const double t = std::asin(0.5 / kIndex);
        const double level = sun.passed / 16;
        const double expected = level * 2 * 0.02 * (std::cos(slope) + std::sin(slope) * std::tan(t));
        EXPECT_NEAR(thin, expected, 0.01 * expected) << slope_degrees;
    }
}

TEST(Walls, ThroughTheSurfaceAndAlongTheLight) {
    scene::FrameState state = test::clear_sea(4, 30, 200);
    state.water->surface.waves.waves = {test::wave(0.8, 30, 0.004), test::wave(0.5, 100, 0.002, 1)};
    const CaughtLight passed(state, Event::transmission);
    // A wall at x = 0.3 and the floor behind and before it share the light of the patch.
    const double depth = 2;
    const double on_wall = passed.on({{0.3, -depth, -4}, {0, depth + 1, 0}, {0, 0, 8}}, 256);
    const double behind_wall = passed.on({{0.3, -depth, -4}, {0, 0, 8}, {0, depth + 1, 0}}, 64);
    EXPECT_EQ(behind_wall, 0) << "light travels along +x";
    // Everything that passes x = 0.3 above the floor would land on the floor beyond.
    const test::SunOnMesh sun =
        test::sun_on_mesh(passed.scene().water->mesh, state.lights[0].direction, kIndex);
    const double t = std::asin(0.5 / kIndex), across = depth * std::tan(t);
    // By flat water; the waves move the share by their height's part of the width only.
    EXPECT_NEAR(on_wall, sun.passed / 4 * across, 0.01 * sun.passed / 4 * across);
    // A plane that contains the mean ray gets what little the waves throw on its sides, and nothing infinite.
    const glm::dvec3 ray(std::sin(t), -std::cos(t), 0);
    const glm::dvec3 start(-0.5, 0.02, -2);
    const double one = passed.on({start, 2.0 * ray, {0, 0, 4}}, 64);
    const double other = passed.on({start, {0, 0, 4}, 2.0 * ray}, 64);
    printf("along the light: %.3g and %.3g W of %.3g W\n", one, other, sun.passed);
    EXPECT_GT(one, 0);
    EXPECT_GT(other, 0);
    EXPECT_LT(one + other, 0.1 * sun.passed);
    // With flat water it gets nothing but rounding.
    state.water->surface.waves.waves.clear();
    const CaughtLight flat(state, Event::transmission);
    EXPECT_LT(flat.on({start, 2.0 * ray, {0, 0, 4}}, 64), 1e-3 * sun.passed);
}

}  // namespace
}  // namespace dapple
