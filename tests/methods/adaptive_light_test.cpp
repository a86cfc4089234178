#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "adaptive_scene.h"
#include "light/beam_axes.h"
#include "light/water_beams.h"
#include "methods/adaptive_beams/beam_pieces.h"
#include "methods/adaptive_beams/make_beams.h"
#include "methods/adaptive_beams/refinement.h"
#include "optics/optics.h"

namespace dapple::methods::adaptive_beams {
namespace {

using light::Event;

constexpr auto kT = Event::transmission;
constexpr auto kR = Event::reflection;

/// The light side of one frame.
struct Made {
    std::vector<BeamSet> sets;
    FrameStats stats;

    Made(const scene::FrameScene& scene, std::vector<light::Chain> chains) {
        static gpu::Device device{gpu::DeviceOptions{}};
        const rays::RayScene rays(scene);
        FrameContext context{scene, rays, device, stats, std::move(chains)};
        sets = make_beams(context);
    }
    /// W, of the legs that begin at the first surface.
    double first_legs() const {
        double sum = 0;
        for (const BeamSet& set : sets)
            if (set.name.find(" > ") == set.name.rfind(" > ")) sum += flux(set);
        return sum;
    }
    static double flux(const BeamSet& set) {
        double sum = 0;
        for (const glm::vec3& flux : set.flux) sum += test::mean(glm::dvec3(flux));
        return sum;
    }
    double losses() const {
        double sum = 0;
        for (const auto& [name, amount] : stats.counts())
            if (name.starts_with("lost")) sum += amount;
        return sum;
    }
    double beams() const { return stats.counted("beams"); }
};

/// A body over a floor, in the sun.
std::unique_ptr<scene::FrameScene> in_the_sun(const scene::Object& body, double floor, double elevation) {
    auto scene = std::make_unique<scene::FrameScene>();
    scene->state.objects = {body, test::floor_at(floor, 100)};
    scene->state.lights.push_back(test::sun_at(elevation));
    return scene;
}

/// The pool over a floor 2 m down, in the sun.
std::unique_ptr<scene::FrameScene> pool_in_the_sun(double amplitude, double elevation, int cells = 64) {
    auto scene = in_the_sun(test::floor_at(-2, 40), -2, elevation);
    scene->state.objects.pop_back();
    test::add_water(*scene, amplitude, cells);
    return scene;
}

TEST(AdaptiveLight, FlatWaterIsOneSetOfParallelRays) {
    for (const double elevation : {90.0, 45.0}) {
        const auto pool = pool_in_the_sun(0, elevation);
        const scene::FrameScene& scene = *pool;
        const Made made(scene, {{0, kT}});
        ASSERT_EQ(made.sets.size(), 1U);
        const BeamSet& set = made.sets[0];
        EXPECT_EQ(set.name, "sun > water:T");
        EXPECT_TRUE(set.in_water);
        const double i = (90 - elevation) * scene::kDegree, t = std::asin(std::sin(i) / 1.333);
        for (const BeamSet::Vertex& v : set.vertices) {
            EXPECT_NEAR(v.slope_a, 0, 1e-7);
            EXPECT_NEAR(v.slope_b, 0, 1e-7);
            EXPECT_NEAR(v.end - v.start, 2 / std::cos(t), 1e-5);
        }
        // Nothing asks for more beams than the coarse grid has.
        EXPECT_EQ(set.triangles.size(), 512U);
    }
}

TEST(AdaptiveLight, FluxesAddUpOverFlatWater) {
    for (const double elevation : {90.0, 45.0}) {
        const auto pool = pool_in_the_sun(0, elevation);
        const scene::FrameScene& scene = *pool;
        const Made made(scene, {{0, kT}, {0, kR}});
        // What the view leaves out at the outline of the water is 4e-6 of it.
        const double sent = 16 * 2.5 * std::sin(elevation * scene::kDegree);
        EXPECT_NEAR((made.first_legs() + made.losses()) / sent, 1, 1e-5);
        const double cos_i = std::sin(elevation * scene::kDegree);
        const double cos_t = optics::f64::transmitted_cosine(cos_i, 1 / 1.333);
        EXPECT_NEAR(Made::flux(made.sets.at(0)) / sent,
                    optics::f64::fresnel_transmittance(cos_i, cos_t, 1 / 1.333), 1e-5);
    }
}

TEST(AdaptiveLight, FluxesAddUpOverWaves) {
    const auto pool = pool_in_the_sun(0.01, 60);
    const scene::FrameScene& scene = *pool;
    const Made made(scene, {{0, kT}, {0, kR}});
    // No later surfaces are met here, so every loss is one of the first legs.
    const double incident = made.stats.counted("light on specular surfaces, W");
    EXPECT_NEAR((made.first_legs() + made.losses()) / incident, 1, 1e-5);
    // The whole against the beams of the water's own mesh. Its outline is thrown up to 6 cm sideways by waves
    // of 0.4 to 1.6 m (wave number k of 8 /m); between rays d = 3 cm apart it is met by chords, which are off
    // by up to 0.06 m (k d)^2 / 8 = 0.4 mm of the pool's 4 m on each of its sides.
    const rays::RayScene rays(scene);
    double sent = 0;
    for (const Event event : {kT, kR}) {
        FrameStats stats;
        for (const auto& sheet : light::water_beams<double>(scene, rays, {0, event}, 1, stats))
            for (const double flux : sheet.flux) sent += flux * test::mean(sheet.color);
    }
    EXPECT_NEAR(incident / sent, 1, 2e-3);
    // Sets are within their cones (but for a float's rounding), and beams have flux.
    for (const BeamSet& set : made.sets) {
        for (const BeamSet::Vertex& v : set.vertices)
            EXPECT_GT(1 / glm::length(glm::dvec3(v.slope_a, v.slope_b, 1)), light::kConeCosine - 1e-6);
        for (const glm::vec3& flux : set.flux) {
            EXPECT_GE(std::min({flux.x, flux.y, flux.z}), 0);
            EXPECT_GT(std::max({flux.x, flux.y, flux.z}), 0);
        }
    }
}

TEST(AdaptiveLight, LampsSendWhatTheBeamsOfTheMeshDo) {
    // Above the water, so near that a cube of views is needed, and under it, where light is reflected
    // totally.
    for (const glm::dvec3 position : {glm::dvec3(0.5, 1, -0.3), {0.1, 0.3, 0}, {0.2, -1, 0.1}}) {
        const auto pool = pool_in_the_sun(0.003, 60, position.y < 0 ? 512 : 256);
        scene::Light& lamp = pool->state.lights[0];
        lamp.type = scene::LightType::point;
        lamp.position = position;
        // Light of a lamp under water that is mirrored meets the floor, and that which leaves it a ceiling.
        pool->state.objects.push_back(test::floor_at(6, 400));
        const rays::RayScene rays(*pool);
        for (const Event event : {kT, kR}) {
            const Made made(*pool, {{0, event}});
            FrameStats stats;
            double expected = 0;
            for (const auto& sheet : light::water_beams<double>(*pool, rays, {0, event}, 1, stats))
                for (const double flux : sheet.flux) expected += flux * test::mean(sheet.color);
            // Shares are means of the three corners' in the mesh as in the grid. For the lamp under water the
            // mesh leaves out whole triangles at the critical angle, 1.1 m away: 8 mm wide, half of them lit.
            const bool below = position.y < 0;
            EXPECT_NEAR(made.first_legs() / expected, 1, below ? 7e-3 : 3e-3) << position.y;
            EXPECT_EQ(made.sets.at(0).in_water, below == (event == kR));
        }
    }
}

TEST(AdaptiveLight, FluxesAddUpThroughABall) {
    scene::Object ball = test::glass_ball({0, 2, 0}, 0.5, 1.5);
    ball.material.absorption = {0.1, 0.5, 2};
    const auto scene_of_ball = in_the_sun(ball, 0, 70);
    const scene::FrameScene& scene = *scene_of_ball;
    const Made made(scene, {{0, kT, 0}, {0, kR, 0}});
    const double incident = made.stats.counted("light on specular surfaces, W");
    EXPECT_NEAR((made.first_legs() + made.losses()) / incident, 1, 1e-5);
    // The outline is a polygon with an edge an eighth of a cell, 1 / 128 of the view, whose corners lie
    // within a 4096th of that of the circle.
    EXPECT_NEAR(incident / (2.5 * std::numbers::pi * 0.25), 1, 1e-3);
    EXPECT_GT(made.stats.counted("lost to absorption in glass, W"), 0);
    EXPECT_GT(made.stats.counted("lost to reflection inside glass, W"), 0);
    EXPECT_EQ(made.sets.at(0).name, "sun > ball:TT");
}

TEST(AdaptiveLight, LaterLegsTakeWhatEndsAtTheWater) {
    // Light of a ball over water: what goes on into the water and what is named as lost there is what the
    // beams that end at the water bring.
    const auto pool = in_the_sun(test::glass_ball({0, 1, 0}, 0.3, 1.5), -2, 80);
    test::add_water(*pool, 0);
    const scene::FrameScene& scene = *pool;
    const rays::RayScene rays(scene);
    const media::Media media(scene);
    const LightView view = LightViews(scene).of(0, scene.state.lights[0].direction, 1, 0).at(0);
    const PathTracer tracer(scene, rays, media, view, 0, 1);
    FrameStats stats;
    RefinedGrid refined = refine(scene, tracer, 0, 16, 2, nullptr, stats);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& t : refined.grid.triangles()) triangles.push_back(t.vertices);
    const BeamHarvest harvest = cut_into_beams(tracer, view, kT, triangles, false, refined.rays);
    double arrives = 0, goes_on = 0;
    for (const LegBeams& legs : harvest.legs)
        for (const LegBeam& beam : legs.beams) {
            if (legs.leg == 1) goes_on += test::mean(beam.flux);
            if (legs.leg == 0 && refined.rays.paths[beam.rays[0]].paths[0].legs[0].end == kEndsAtWater)
                arrives += test::mean(beam.flux);
        }
    const double reflected = test::mean(harvest.losses[static_cast<std::size_t>(Cause::later_reflection)]);
    EXPECT_GT(goes_on, 0.5);
    EXPECT_NEAR((goes_on + reflected) / arrives, 1, 1e-6);
}

TEST(AdaptiveLight, TotalReflectionInABlockIsCounted) {
    // Light that enters the top of a block of n = 1.5 leaves by the bottom, but for what meets a side first:
    // there and for light that enters at the side and meets the bottom it is reflected totally, n being >
    // sqrt 2.
    scene::Object block = test::glass_ball({0, 0, 0}, 0, 1.5);
    block.shape = scene::Shape::box;
    block.size = {2, 1, 3};
    const Made made(*in_the_sun(block, -4, 60), {{0, kT, 0}});
    const double i = 30 * scene::kDegree, t = std::asin(std::sin(i) / 1.5);
    const double j = 60 * scene::kDegree, s = std::asin(std::sin(j) / 1.5);
    const auto enters = [](double in, double out) {
        return optics::f64::fresnel_transmittance(std::cos(in), std::cos(out), 1 / 1.5);
    };
    const double top = 2.5 * 6 * std::cos(i) * enters(i, t), side = 2.5 * 3 * std::cos(j) * enters(j, s);
    // Of the top's light the part within tan t of the far side; of the side's all: it reaches the bottom
    // before the other side.
    ASSERT_GT(2 / std::tan(s), 1);
    const double expected = top * std::tan(t) / 2 + side;
    EXPECT_NEAR(made.stats.counted("lost to total reflection, W") / expected, 1, 1e-3);
}

TEST(AdaptiveLight, TheLastLevelMayLeaveOutSilhouettes) {
    const auto scene_of_ball = in_the_sun(test::glass_ball({0, 2, 0}, 0.5, 1.5), 0, 90);
    scene::FrameScene& scene = *scene_of_ball;
    scene.state.caustics.adaptive_beams.paper_faithful = true;
    double before = 1;
    for (const int levels : {1, 3}) {
        scene.state.caustics.adaptive_beams.levels = levels;
        const Made made(scene, {{0, kT, 0}, {0, kR, 0}});
        // All triangles that the outline crosses are left out: the disc misses about half a cell all around,
        // 4 / cells of its area.
        const double disc = 2.5 * std::numbers::pi * 0.25;
        const double missing =
            1 - made.first_legs() / (disc - made.stats.counted(loss_name(Cause::glass_reflection)));
        EXPECT_NEAR(missing * (16 << levels) / 4, 1, 0.5);
        // What they would carry is known to the same as if their corners were all there is.
        EXPECT_NEAR(made.stats.counted("light on specular surfaces, W") / disc, 1, 0.3 * missing);
        EXPECT_LT(missing, before);
        before = missing;
    }
}

TEST(AdaptiveLight, ALampInABallSendsAllItsLightOut) {
    scene::Object ball = test::glass_ball({0, 2, 0}, 0.5, 1.5);
    ball.material.absorption = {0.1, 0.5, 2};
    const auto lamp_in_ball = in_the_sun(ball, 0, 70);
    scene::FrameScene& scene = *lamp_in_ball;
    scene.state.objects.push_back(test::floor_at(8, 100));
    scene.state.lights[0] = test::lamp_at({0.1, 2.1, 0});
    const Made made(scene, {{0, kT, 0}, {0, kR, 0}});
    // No angle within is as flat as the critical one, so that all of the sphere of directions is sent on.
    const double incident = made.stats.counted("light on specular surfaces, W");
    EXPECT_NEAR(incident / (2.5 * 4 * std::numbers::pi), 1, 1e-6);
    EXPECT_NEAR((made.first_legs() + made.losses()) / incident, 1, 1e-5);
    std::vector<std::string> names;
    for (const BeamSet& set : made.sets) names.push_back(set.name.substr(0, set.name.find(' ', 10)));
    EXPECT_THAT(names, ::testing::Contains("lamp > ball:T"));
    EXPECT_THAT(names, ::testing::Contains("lamp > ball:RT"));
}

TEST(AdaptiveLight, DispersionPartsTheChannels) {
    const auto pool = pool_in_the_sun(0, 45);
    scene::FrameScene& scene = *pool;
    const double total = Made(scene, {{0, kT}}).beams();
    scene.state.water->dispersion = 0.03;
    // Where what the water mirrors is seen; it leaves the sun's way free.
    scene.state.objects.push_back(test::floor_at(6, 5));
    scene.state.objects.back().transform.position.x = -6;
    const Made made(scene, {{0, kT}, {0, kR}});
    ASSERT_EQ(made.sets.size(), 4U);
    EXPECT_EQ(made.sets[0].name, "sun > water:R");
    const std::array<const char*, 3> names = {"sun > water:T red", "sun > water:T green",
                                              "sun > water:T blue"};
    const double i = 45 * scene::kDegree;
    for (int c = 0; c < 3; ++c) {
        const BeamSet& set = made.sets[static_cast<std::size_t>(c) + 1];
        EXPECT_EQ(set.name, names[static_cast<std::size_t>(c)]);
        const double n = 1.333 + 0.015 * (c - 1), t = std::asin(std::sin(i) / n);
        // Snell's law, and Fresnel's by the colour's index.
        EXPECT_NEAR(set.world_from_mesh[2].x, -std::sin(t), 1e-9);
        glm::dvec3 flux(0);
        for (const glm::vec3& beam : set.flux) flux += glm::dvec3(beam);
        const double share = optics::f64::fresnel_transmittance(std::cos(i), std::cos(t), 1 / n);
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(flux[k] / (16 * std::cos(i) * (3 - 0.5 * k)), k == c ? share : 0, 1e-5);
        EXPECT_EQ(static_cast<double>(set.triangles.size()), total);
    }
}

TEST(AdaptiveLight, DispersionActsBehindGlassToo) {
    // A ball over water: what goes on into the water leaves the surface by three directions.
    const auto pool = in_the_sun(test::glass_ball({0, 1, 0}, 0.3, 1), -2, 60);
    scene::FrameScene& scene = *pool;
    test::add_water(scene, 0);
    scene.state.water->dispersion = 0.03;
    const Made made(scene, {{0, kT, 0}});
    std::vector<double> sines;
    for (const BeamSet& set : made.sets)
        if (set.name.starts_with("sun > ball:TT > water:T")) sines.push_back(-set.world_from_mesh[2].x);
    // The ball does not bend light.
    EXPECT_THAT(sines, ::testing::ElementsAre(::testing::DoubleNear(0.5 / 1.318, 1e-6),
                                              ::testing::DoubleNear(0.5 / 1.333, 1e-6),
                                              ::testing::DoubleNear(0.5 / 1.348, 1e-6)));
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
