// The brute-force reference follows light through bodies of glass in water and in its surface: closed forms
// of E.
#include <gtest/gtest.h>

#include "methods/reference_glass_frame.h"

namespace dapple {
namespace {

using namespace test;

TEST(ReferenceGlass, GlassOfWaterInWaterIsNotThere) {
    scene::FrameState state = small_pool(3, 2, 1, 8);
    scene::Object ball = glass(scene::Shape::sphere, {0.1, -1, 0}, state.water->refractive_index);
    ball.radius = 0.7;
    ball.material.absorption = state.water->absorption;
    state.objects.push_back(ball);
    state.camera.position.y = -1.8;
    state.camera.target.y = -2;
    state.lights = {sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    GlassFrame frame(state);
    frame.chains = {{0, kThrough}, {0, kThrough, 1}, {0, kBack, 1}};
    const FlatFloor exact = flat_floor(35, 2, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    const LayerResult result = frame.render();
    expect_agreement(agreement(result, std::vector<double>(64, e)));
    // All of it is the water's own.
    frame.chains = {{0, kThrough, 1}, {0, kBack, 1}};
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(ReferenceGlass, BlockInTheSurface) {
    // Half in the air and half in the water, light straight down: T1 T2 a / (1 - R1 R2 a^2), then the water.
    scene::FrameState state = small_pool(3, 1, 0.4, 8);
    scene::Object block = glass(scene::Shape::box, {0, -0.1, 0}, 1.6);
    block.size = {1, 0.8, 1};
    block.material.absorption = {0.7, 0.2, 0};
    state.objects.push_back(block);
    state.camera.position.y = -0.8;
    state.lights = {sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    for (const double height : {0.0, 0.02}) {
        // Level, and with waves, which the block's bottom does not meet.
        if (height > 0) state.water->surface.waves.waves = {{0.5, 0, height, 0}};
        GlassFrame frame(state);
        frame.chains = {{0, kThrough, 1}};
        const LayerResult result = frame.render();
        for (int channel = 0; channel < 3; ++channel) {
            const double r1 = refract(0, 1, 1.6).reflectance;
            const double r2 = refract(0, 1.6, state.water->refractive_index).reflectance;
            const double a = std::exp(-0.8 * block.material.absorption[channel]);
            const double e = state.lights[0].irradiance[channel] * (1 - r1) * (1 - r2) * a /
                             (1 - r1 * r2 * a * a) * std::exp(-0.5 * state.water->absorption[channel]);
            expect_agreement(agreement(result, std::vector<double>(64, e), channel));
        }
    }
}

/// What a lamp's light comes to below a level block: through glass between the air and the water.
double through_block(const scene::FrameState& state, double zenith, double thickness, double below,
                     int channel) {
    const scene::Material& glass = state.objects[1].material;
    const double n = state.water->refractive_index;
    const Refraction in = refract(glm::radians(zenith), 1, glass.refractive_index);
    const Refraction out = refract(in.angle, glass.refractive_index, n);
    const double a = std::exp(-glass.absorption[channel] * thickness / std::cos(in.angle));
    const double r1 = in.reflectance, r2 = out.reflectance;
    return state.lights[0].irradiance[channel] * std::cos(glm::radians(zenith)) * (1 - r1) * (1 - r2) * a /
           (1 - r1 * r2 * a * a) * std::exp(-state.water->absorption[channel] * below / std::cos(out.angle));
}

TEST(ReferenceGlass, AFaceInTheSurfaceOfTheWater) {
    // The block's top or bottom lies in flat water: there is no film of water on it, above or below. What
    // the sides reflect, or let in, reaches the floor beside the part that is seen.
    for (const double middle : {-0.2, 0.2}) {
        for (const double zenith : {0.0, 35.0}) {
            scene::FrameState state = small_pool(4, 1, 0.5, 4);
            scene::Object block = glass(scene::Shape::box, {0, middle, 0}, 1.6);
            block.size = {3, 0.4, 1.2};
            block.material.absorption = {0.7, 0.2, 0};
            state.objects.push_back(block);
            state.lights = {sun_from_zenith(zenith)};
            const double below = middle < 0 ? 0.6 : 1;
            // What is lit through the block's middle.
            const double in = refract(glm::radians(zenith), 1, 1.6).angle;
            const double out = refract(in, 1.6, state.water->refractive_index).angle;
            const double x = 0.2 * std::tan(in) + below * std::tan(out);
            state.camera.position = {x, -0.7, 0};
            state.camera.target.x = x;
            state.caustics.reference = kOneRound;
            GlassFrame frame(state);
            // Light that meets the water at the block would be counted twice.
            frame.chains = {{0, kThrough}, {0, kThrough, 1}, {0, kBack, 1}};
            const LayerResult result = frame.render();
            const std::vector<double> e(16, through_block(state, zenith, 0.4, below, 0));
            expect_agreement(agreement(result, e));
            // And where the face is not the first thing that light meets: after a ball that does not bend it.
            scene::FrameState after = state;
            after.objects.push_back(glass(scene::Shape::sphere, {0, 3, 0}, 1));
            after.objects.back().radius = 1;
            const double aside = std::tan(glm::radians(zenith)) * (middle < 0 ? 3 : 2.6);
            after.objects.back().transform.position.x = -aside;
            GlassFrame second(after);
            second.chains = {{0, kThrough, 2}};
            expect_agreement(agreement(second.render(), e));
        }
    }
}

}  // namespace
}  // namespace dapple
