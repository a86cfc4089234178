// Sliced beams as they are rendered, in float, against closed forms and the balance of energy.
#include <gtest/gtest.h>

#include "base/parallel.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "gpu/validated_device.h"
#include "methods/registry.h"
#include "ocean/water_surface.h"
#include "render/frame_renderer.h"
#include "render/frame_scene_builder.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;
const char* const kLetters = "RGB";

render::RenderedFrame render_frame(const scene::FrameState& state) {
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    render::RenderedFrame frame = renderer.render(state, stats);
    EXPECT_EQ(frame.non_finite.count, 0u);
    return frame;
}

const std::vector<float>& values(const render::RenderedFrame& frame, const std::string& name) {
    const image::Channel* channel = frame.linear.find(name);
    if (!channel) throw std::runtime_error("no channel " + name);
    return channel->values;
}

/// Level floor 2 m down, seen squarely from below the surface; the view is in the middle of the lit part.
scene::FrameState floor_state(double patch, double zenith_degrees, double view, int pixels, int cells) {
    scene::FrameState state = test::pool_over_floor(patch, 2, view, pixels);
    state.caustics.method = "sliced_beams";
    state.water->mesh_cells = cells;
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.lights = {test::sun_from_zenith(zenith_degrees)};
    state.camera.position.x = state.camera.target.x =
        2 * std::tan(std::asin(std::sin(glm::radians(zenith_degrees)) / kIndex));
    return state;
}

class BeamsRendered : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, BeamsRendered, testing::Values(0.0, 30.0, 60.0, 80.0, 89.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(BeamsRendered, FlatWaterIsRightInTheWorstPixel) {
    // Beams 0.2 m wide 3 m from the origin: their corners are rounded by 1.2e-7 m, which is 1e-6 of the area
    // of a beam; narrower beams lose more, in pixels that they are larger than.
    const scene::FrameState state = floor_state(6, GetParam(), 1.6, 64, 30);
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(GetParam(), 2, kIndex);
    double worst = 0, worst_mean = 0;
    for (int c = 0; c < 3; ++c) {
        const double expected = state.lights[0].irradiance[c] * floor.irradiance *
                                std::exp(-state.water->absorption[c] * floor.way);
        double mean = 0;
        const std::vector<float>& picture = values(frame, std::string("E.") + kLetters[c]);
        for (const float value : picture) {
            worst = std::max(worst, std::abs(value / expected - 1));
            mean += value / expected / static_cast<double>(picture.size());
        }
        worst_mean = std::max(worst_mean, std::abs(mean - 1));
    }
    for (const float covered : values(frame, "covered")) ASSERT_EQ(covered, 1);
    printf("sun %2.0f deg from the zenith: E off by %.1e in the worst pixel, %.1e in the mean\n", GetParam(),
           worst, worst_mean);
    EXPECT_LT(worst, 1e-5);
    EXPECT_LT(worst_mean, 1e-6);
}

TEST_P(BeamsRendered, RadianceSeenFromAboveIsReflectedIrradianceOverIndexSquared) {
    scene::FrameState state = floor_state(8, GetParam(), 0, 48, 100);
    const double shift = state.camera.position.x;
    state.camera.projection = scene::Projection::perspective;
    state.camera.field_of_view = glm::radians(30.0);
    state.camera.position = {shift + 1.2, 2.5, 0.4};  // looks in at a slant
    state.camera.target = {shift, -1, 0};
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(GetParam(), 2, kIndex);
    const glm::dvec3 forward = glm::normalize(state.camera.target - state.camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, state.camera.up));
    const glm::dvec3 up = glm::cross(right, forward);
    const double pixel = 2 * std::tan(0.5 * state.camera.field_of_view) / 48;
    double worst = 0;
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 48; ++x) {
            const glm::dvec3 view = glm::normalize(forward + pixel * ((x - 23.5) * right - (y - 23.5) * up));
            const double cos_i = -view.y, sin_t = std::sqrt(1 - cos_i * cos_i) / kIndex;
            const double cos_t = std::sqrt(1 - sin_t * sin_t);
            const double rs = (cos_i - kIndex * cos_t) / (cos_i + kIndex * cos_t);
            const double rp = (kIndex * cos_i - cos_t) / (kIndex * cos_i + cos_t);
            const double outwards = (1 - 0.5 * (rs * rs + rp * rp)) / (kIndex * kIndex);
            for (int c = 0; c < 3; ++c) {
                const double expected = state.objects[0].material.color[c] * glm::one_over_pi<double>() *
                                        state.lights[0].irradiance[c] * floor.irradiance * outwards *
                                        std::exp(-state.water->absorption[c] * (floor.way + 2 / cos_t));
                const float value = values(
                    frame, std::string("caustics.") + kLetters[c])[static_cast<std::size_t>(y * 48 + x)];
                worst = std::max(worst, std::abs(value / expected - 1));
            }
        }
    }
    printf("sun %2.0f deg from the zenith: radiance from above off by %.1e in the worst pixel\n", GetParam(),
           worst);
    // 0.5 % is what is asked for; E is right to 1e-5 where beams are larger than pixels, the rest is some ten
    // roundings to float and the footprint's linearity.
    EXPECT_LT(worst, 1e-4);
}

/// Flux landed on 8 m of receiver in 256^2 pixels over what the mesh passes; E is that of the red channel.
double landed_over_passed(const scene::FrameState& state, bool reflected) {
    const render::RenderedFrame frame = render_frame(state);
    double landed = 0;
    for (const float value : values(frame, "E.R")) landed += value;
    landed *= std::pow(8.0 / 256, 2);
    const test::MeshFlux flux =
        test::flux_through(ocean::WaterSurface(*state.water).mesh(0), state.lights[0].direction, kIndex);
    return landed / state.lights[0].irradiance.x / (reflected ? flux.reflected : flux.transmitted);
}

TEST(BeamsEnergy, AFloorCatchesTheRefractedFlux) {
    scene::FrameState state = floor_state(4, 30, 8, 256, 0);
    state.water->absorption = glm::dvec3(0);
    state.water->surface.waves = test::gentle_waves();
    const double share = landed_over_passed(state, false);
    printf("floor: flux landed over flux through the surface: 1 %+.2e\n", share - 1);
    EXPECT_NEAR(share, 1, 1e-6);
}

TEST(BeamsEnergy, ACeilingCatchesTheReflectedFlux) {
    scene::FrameState state = floor_state(4, 60, 8, 256, 0);
    state.water->surface.waves = test::gentle_waves();
    const double height = 3, across = height * std::tan(glm::radians(60.0));
    // Beside the patch, so that it does not shade the water on the light's way down.
    state.objects = {test::level_plane("ceiling", height, 9)};
    state.objects[0].transform.position.x = across + 0.5;
    state.camera.position = {across, 0.5, 0};
    state.camera.target = {across, 1, 0};
    const double share = landed_over_passed(state, true);
    printf("ceiling: flux landed over flux off the surface: 1 %+.2e\n", share - 1);
    EXPECT_NEAR(share, 1, 1e-6);
}

/// A square column, 0.3 m wide, through the surface to 0.5 m above it.
scene::FrameState column_state() {
    scene::FrameState state = floor_state(6, 45, 3, 150, 300);
    scene::Object column;
    column.name = "column";
    column.shape = scene::Shape::box;
    column.size = {0.3, 3, 0.3};
    column.transform.position = {0, -1, 0};
    state.objects.push_back(column);
    state.camera.position.x = state.camera.target.x = 0.6;
    return state;
}

TEST(BeamsColumn, TheUmbraIsDarkAndTheRestIsFlatWaters) {
    const scene::FrameState state = column_state();
    const render::RenderedFrame frame = render_frame(state);
    const test::FlatFloor floor = test::flat_floor(45, 2, kIndex);
    const double expected =
        state.lights[0].irradiance.x * floor.irradiance * std::exp(-state.water->absorption.x * floor.way);
    // Sun along +x: the water hides the floor from the column's foot to where light lands that just misses
    // its top: 0.5 tan(i) on the water and the way through the water from there.
    const double t = std::asin(std::sin(glm::radians(45.0)) / kIndex);
    const double end = 0.15 + 0.5 + 2 * std::tan(t);
    // Beams (2 cm) and pixels (2 cm) that straddle the outline are lit by the beam's middle.
    const double margin = 0.041;
    int dark = 0, lit = 0;
    double worst = 0, brightest = 0;
    for (int y = 0; y < 150; ++y) {
        for (int x = 0; x < 150; ++x) {
            const double at_x = state.camera.position.x + 0.02 * (x - 74.5), at_z = 0.02 * (y - 74.5);
            const float value = values(frame, "E.R")[static_cast<std::size_t>(y * 150 + x)];
            if (std::abs(at_x) < 0.15 + margin && std::abs(at_z) < 0.15 + margin) continue;  // the column
            // Distance outside of the outline, negative inside.
            const double outside = std::max({-0.15 - at_x, at_x - end, std::abs(at_z) - 0.15});
            if (outside < -margin) {
                ASSERT_EQ(value, 0) << at_x << ' ' << at_z;
                ++dark;
            } else if (outside > margin) {
                worst = std::max(worst, std::abs(value / expected - 1));
                ++lit;
            } else {
                brightest = std::max(brightest, value / expected - 1);
            }
        }
    }
    printf("column: %d pixels dark, %d lit, these off by %.1e\n", dark, lit, worst);
    EXPECT_GT(dark, 500);
    EXPECT_GT(lit, 15000);
    EXPECT_LT(worst, 1e-4);      // corners' roundings over beams of 2 cm, as above
    EXPECT_LT(brightest, 1e-4);  // nothing is brighter than flat water
}

TEST(BeamsColumn, ItsSideTowardsTheSunIsLitAndTheOtherDark) {
    for (const double side : {-1.0, 1.0}) {
        scene::FrameState state = column_state();
        // Level view of the face, 0.24 m of it, at 1 m depth.
        state.clip.width = state.clip.height = 48;
        state.camera.up = {0, 1, 0};
        state.camera.view_height = 0.24;
        state.camera.position = {side * 1.5, -1, 0};
        state.camera.target = {0, -1, 0};
        state.objects[0].transform.position.y = -2.4;
        const render::RenderedFrame frame = render_frame(state);
        const double t = std::asin(std::sin(glm::radians(45.0)) / kIndex);
        const test::FlatFloor level = test::flat_floor(45, 1, kIndex);
        double worst = 0;
        for (int y = 0; y < 48; ++y) {
            // Mean over the pixel of exp(-absorption depth / cos t): its middle, to 1e-6.
            const double depth = 1 + 0.005 * (y - 23.5);
            const double expected = state.lights[0].irradiance.x * level.irradiance * std::tan(t) *
                                    std::exp(-state.water->absorption.x * depth / std::cos(t));
            for (int x = 0; x < 48; ++x) {
                const float value = values(frame, "E.R")[static_cast<std::size_t>(y * 48 + x)];
                if (side > 0)
                    ASSERT_EQ(value, 0);
                else
                    worst = std::max(worst, std::abs(value / expected - 1));
            }
        }
        if (side < 0) printf("column's lit side: off by %.1e\n", worst);
        // A beam of 2 cm, which lands over 3 cm of the wall, is absorbed over the mean of its corners' ways:
        // up to 2.5 cm off, 0.4 / m.
        EXPECT_LT(worst, 0.01);
    }
}

TEST(BeamsWall, StandsInTheLightFromTheWaterLineDown) {
    // A wall at x = 0.5 across the sun's way, from 0.5 m above to 1 m below flat water.
    scene::FrameState state = floor_state(6, 45, 1.5, 150, 300);
    state.water->absorption = {0, 0.1, 0.4};
    scene::Object wall = test::level_plane("wall", 0, 4);
    wall.transform.rotation.z = glm::radians(90.0);
    wall.transform.position = {0.5, 0, 0};
    state.objects.push_back(wall);
    state.camera.up = {0, 1, 0};
    state.camera.position = {-1, -0.25, 0};
    state.camera.target = {0, -0.25, 0};
    const render::RenderedFrame frame = render_frame(state);
    const double t = std::asin(std::sin(glm::radians(45.0)) / kIndex);
    const test::FlatFloor level = test::flat_floor(45, 1, kIndex);
    double worst[2] = {0, 0};
    double mirrored = 0;
    // A unit of level water sends up what it does not pass, onto sin / cos of the wall.
    const double above = state.lights[0].irradiance.x * (std::cos(glm::radians(45.0)) - level.irradiance) *
                         std::tan(glm::radians(45.0));
    int under = 0;
    for (int y = 0; y < 150; ++y) {
        const double height = 0.5 - 0.01 * (y + 0.5);
        for (int x = 40; x < 110; ++x) {
            const std::size_t i = static_cast<std::size_t>(y * 150 + x);
            if (height > 0) {  // no light from under water, only what the water mirrors
                mirrored = std::max(mirrored, std::abs(values(frame, "E.R")[i] / above - 1));
                continue;
            }
            ++under;
            for (int c = 0; c < 3; c += 2) {
                const double expected = state.lights[0].irradiance[c] * level.irradiance * std::tan(t) *
                                        std::exp(state.water->absorption[c] * height / std::cos(t));
                worst[c / 2] = std::max(
                    worst[c / 2], std::abs(values(frame, std::string("E.") + kLetters[c])[i] / expected - 1));
            }
        }
    }
    printf("wall: off by %.1e without absorption, %.1e with 0.4 / m, above the water %.1e\n", worst[0],
           worst[1], mirrored);
    EXPECT_EQ(under, 100 * 70);
    EXPECT_LT(mirrored, 1e-4);
    EXPECT_LT(worst[0], 1e-4);  // roundings over beams of 2 cm
    EXPECT_LT(worst[1], 0.01);  // as for the column's side
}

/// A sea with all that takes paths apart: waves, a column, a mirror, a lamp and several samples.
scene::FrameState crowded_state() {
    scene::FrameState state = floor_state(4, 40, 2, 40, 120);
    state.clip.samples = 6;  // two batches of layers
    state.water->surface.waves = test::gentle_waves();
    state.lights[0].angular_diameter = 0.0093;
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0.4, 1, 0.3};
    state.lights.push_back(lamp);
    scene::Object column;
    column.name = "column";
    column.shape = scene::Shape::box;
    column.size = {0.3, 3, 0.3};
    column.transform.position = {1, -1, 0};
    column.transform.rotation.y = 0.5;
    state.objects.push_back(column);
    scene::Object ball;
    ball.name = "ball";
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.3;
    ball.transform.position = {0.5, -1.6, 0.4};
    state.objects.push_back(ball);
    return state;
}

TEST(BeamsBits, AreTheSameOnAnyNumberOfThreads) {
    const scene::FrameState state = crowded_state();
    set_thread_count(1);
    const render::RenderedFrame one = render_frame(state);
    set_thread_count(2);
    const render::RenderedFrame two = render_frame(state);
    set_thread_count(0);
    ASSERT_EQ(one.linear.channels.size(), two.linear.channels.size());
    for (std::size_t i = 0; i < one.linear.channels.size(); ++i)
        EXPECT_EQ(one.linear.channels[i].values, two.linear.channels[i].values)
            << one.linear.channels[i].name;
    // And there is something to be equal.
    const auto& picture = values(one, "E.G");
    EXPECT_GT(*std::max_element(picture.begin(), picture.end()),
              2 * *std::min_element(picture.begin(), picture.end()));
}

TEST(BeamsBits, AreTheSameForLayersAloneAndTogether) {
    const scene::FrameState state = crowded_state();
    const scene::FrameScene scene = render::FrameSceneBuilder().build(state);
    const rays::RayScene rays(scene);
    FrameStats stats;
    const auto method = methods::make_method("sliced_beams");
    methods::FrameContext context{scene,
                                  rays,
                                  test::validated_device(),
                                  stats,
                                  {{0, light::Event::transmission}, {1, light::Event::transmission}}};
    method->begin(context);
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 3; ++sample) {
        view::LayerCounts counts;
        layers.push_back(view::trace_layer(scene, rays, {sample, 0}, counts));
    }
    const auto ask = [&](std::span<const view::ReceiverLayer> some) {
        std::vector<methods::LayerResult> results(some.size());
        for (auto& result : results) {
            result.irradiance.assign(layers[0].pixels(), glm::vec3(0));
            result.covered.assign(layers[0].pixels(), 0);
        }
        method->irradiance(context, some, results);
        return results;
    };
    const auto together = ask(layers);
    for (std::size_t i = layers.size(); i-- > 0;) {
        const auto alone = ask(std::span(layers).subspan(i, 1));
        EXPECT_EQ(alone[0].irradiance, together[i].irradiance);
        EXPECT_EQ(alone[0].covered, together[i].covered);
    }
    EXPECT_NE(together[0].irradiance, together[1].irradiance);
}

}  // namespace
}  // namespace dapple
