// Beams of a low sun, by whose light waves hide others: none spans two waves, and each wave has the light
// that an integral over its lit face says.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "adaptive_scene.h"
#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/refinement.h"
#include "optics/optics.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr double kIndex = 1.333;
constexpr double kLength = 1;  // m, of the wave
constexpr int kWaves = 4;
constexpr double kSide = kWaves * kLength;
/// Waves, of kWaves + 2, that are neither the first, which no other hides, nor cut by the end of the pool.
constexpr int kInnerFirst = 1, kInnerLast = kWaves - 1;

/// A pool of kSide by kSide under one wave along x, 2 m deep, in a sun whose light travels along -x.
scene::FrameScene pool(double elevation) {
    scene::FrameScene scene;
    test::add_water(scene, 0, 2);
    scene::Water& water = *scene.state.water;
    water.refractive_index = kIndex;
    water.extent.size = {kSide, kSide};
    water.mesh_cells = 256;
    scene::Wave wave;
    wave.length = kLength;
    wave.amplitude = 0.03;
    wave.phase = 0.7;
    wave.wave_vector = {2 * std::numbers::pi / kLength, 0};
    water.surface.waves.waves = {wave};
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    // What is mirrored goes on under a ceiling that does not shade the pool.
    scene.state.objects = {test::floor_at(-2, 100), test::floor_at(6, 400)};
    scene.state.objects[1].transform.position.x = -190;
    scene.state.lights.push_back(test::sun_at(elevation));
    scene.state.clip.width = 96;
    scene.state.clip.height = 54;
    scene.state.camera.position = {-1, -1, 8};
    scene.state.camera.target = {-1, -1, 0};
    scene.state.camera.field_of_view = 60 * scene::kDegree;
    return scene;
}

/// Where the water is highest, m, in the middle of [-kSide / 2, kSide / 2] or up to a wave beside it.
double crest(const ocean::WaterSurface& surface) {
    double best = 0, highest = -1;
    for (int i = 0; i < 10000; ++i) {
        const double x = kLength * i / 10000, height = surface.sample(x, 0, 0).height;
        if (height > highest) best = x;
        highest = std::max(highest, height);
    }
    return best;
}

/// The wave that a place belongs to: from trough to trough.
int wave_of(double x, double at_crest) {
    return static_cast<int>(std::floor((x - at_crest) / kLength + 0.5));
}

/// What the lit face of one wave, not the first, takes of a sun of 1 W/m^2, W for the pool's width: what goes
/// in, and what is mirrored.
glm::dvec2 taken_by_a_wave(const ocean::WaterSurface& surface, double elevation, double at_crest) {
    const double e = elevation * scene::kDegree;
    constexpr int kSteps = 400000;
    glm::dvec2 sum(0);
    // Towards -x from the crest of the wave before; `passed`: where its light meets the rest plane.
    double passed = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2 * kSteps; ++i) {
        const double x = at_crest + kLength - kLength * i / kSteps;
        const ocean::SurfaceSample at = surface.sample(x, 0, 0);
        const double meets = x - at.height / std::tan(e);
        if (!(meets < passed)) continue;
        const bool of_this_wave = i > kSteps / 2 && i <= 3 * kSteps / 2;
        const double lit = of_this_wave ? (passed - meets) * std::sin(e) * kSide : 0;
        passed = meets;
        if (i == 0) continue;
        const double cos_i = (std::sin(e) - std::cos(e) * at.slope.x) / std::hypot(1, at.slope.x);
        const double cos_t = optics::f64::transmitted_cosine(cos_i, 1 / kIndex);
        const double share = optics::f64::fresnel_transmittance(cos_i, cos_t, 1 / kIndex);
        sum += lit * glm::dvec2(share, 1 - share);
    }
    return sum;
}

class LowSun : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Elevations, LowSun, testing::Values(0.5, 1.5, 4.0));

TEST_P(LowSun, EachWaveHasItsLight) {
    const double elevation = GetParam();
    const scene::FrameScene scene = pool(elevation);
    const ocean::WaterSurface surface(*scene.state.water);
    const double at_crest = crest(surface);
    const glm::dvec2 expected = 3.0 * taken_by_a_wave(surface, elevation, at_crest);

    const rays::RayScene rays(scene);
    const media::Media media(scene);
    const LightView view = LightViews(scene).of(0, scene.state.lights[0].direction, 1, light::kWater).at(0);
    for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
        const PathTracer tracer(scene, rays, media, view, light::kWater, 1u << static_cast<unsigned>(event));
        FrameStats stats;
        RefinedGrid refined = refine(scene, tracer, light::kWater, 16, 3, nullptr, stats);
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const auto& t : refined.grid.triangles()) triangles.push_back(t.vertices);
        const BeamHarvest harvest =
            cut_into_beams(tracer, view, event, triangles, false, refined.rays, refined.entry);
        std::array<double, kWaves + 2> by_wave{};
        double spanning = 0, sum = 0;
        std::size_t beams = 0;
        for (const LegBeams& legs : harvest.legs) {
            if (legs.leg != 0) continue;
            for (const LegBeam& beam : legs.beams) {
                ++beams;
                sum += beam.flux.x;
                std::array<int, 3> wave{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = refined.rays.paths[beam.rays[k]].position.x;
                    wave[k] = wave_of(x, at_crest) + (kWaves + 2) / 2;
                    by_wave.at(static_cast<std::size_t>(wave[k])) += beam.flux.x / 3;
                }
                if (wave[0] != wave[1] || wave[0] != wave[2]) spanning += beam.flux.x;
            }
        }
        const double one = expected[static_cast<int>(event)];
        double worst = 0;
        for (int wave = kInnerFirst; wave <= kInnerLast; ++wave)
            worst = std::max(worst, std::abs(by_wave.at(static_cast<std::size_t>(wave)) / one - 1));
        std::printf("%g deg, %s: %zu beams; light of a wave off by %.1e; %.1e of it in beams between waves\n",
                    elevation, event == light::Event::transmission ? "refracted" : "mirrored", beams, worst,
                    spanning / sum);
        EXPECT_GT(beams, 1000U);
        // The mesh's facets put outlines off by 4e-5 m of height, where the lit face has 9 mm at least; and
        // 16 points a piece see roots of the distance from an outline to a few thousandths.
        EXPECT_LT(worst, 3e-3);
        // Where an outline and an edge of the grid cross twice between two rays.
        EXPECT_LT(spanning / sum, 1e-3);
    }
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
