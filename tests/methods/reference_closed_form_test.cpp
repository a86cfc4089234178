// The brute-force reference against closed forms, and the honesty of its standard errors.
#include "methods/reference/reference.h"

#include <gtest/gtest.h>

#include "methods/reference_frame.h"

namespace dapple {
namespace {

using namespace test;

TEST(Reference, FlatWaterUnderASun) {
    scene::FrameState state = small_pool(3, 1, 1, 32);
    state.caustics.reference = {0.04, 100};
    state.lights = {test::sun_from_zenith(35)};
    Frame frame(state);
    const LayerResult result = frame.render();
    const test::FlatFloor exact = test::flat_floor(35, 1, state.water->refractive_index);
    for (int channel = 0; channel < 3; ++channel) {
        const double e = state.lights[0].irradiance[channel] * exact.irradiance *
                         std::exp(-state.water->absorption[channel] * exact.way);
        expect_agreement(agreement(result, std::vector<double>(1024, e), channel));
    }
    EXPECT_LE(frame.stats.counted("reference standard error"), 0.04);
    EXPECT_GT(frame.stats.counted("reference standard error"), 0);
    // The first round does not reach it: the second one counts.
    EXPECT_EQ(frame.stats.counted("reference passes"), 32);
}

TEST(Reference, DiscOfASun) {
    // A disc of 60 degrees of even radiance overhead: L the integral of cos(i) T exp(-s d / cos(t)) over it,
    // where L pi sin(30 deg)^2 is the irradiance across the sun.
    scene::FrameState state = small_pool(4, 1, 1, 32);
    state.lights = {test::sun_from_zenith(0)};
    state.lights[0].angular_diameter = 60 * scene::kDegree;
    state.caustics.reference = kOneRound;
    double e = 0;
    constexpr int steps = 2000;
    for (int i = 0; i < steps; ++i) {
        const double zenith = 30 * (i + 0.5) / steps;
        const test::FlatFloor at = test::flat_floor(zenith, 1, state.water->refractive_index);
        e += 2 * std::sin(glm::radians(zenith)) * glm::radians(30.0 / steps) * at.irradiance *
             std::exp(-state.water->absorption.x * at.way) / 0.25;
    }
    expect_agreement(agreement(Frame(state).render(), std::vector<double>(1024, 3 * e)));
}

TEST(Reference, AlignedPixelsOfAFloorAreExact) {
    // A light straight down through flat water, strata of a 64th of a pixel (65536 on 32^2 pixels of the
    // very extent): each falls into its pixel, so that no error is left but that of rounding.
    scene::FrameState state = small_pool(1, 1, 1, 32);
    state.objects[0].size = {1, 1, 1};
    state.lights = {test::sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    const LayerResult result = frame.render();
    const test::FlatFloor exact = test::flat_floor(0, 1, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    for (const glm::vec3& found : result.irradiance)
        ASSERT_NEAR(static_cast<double>(found.x), e, 1e-6 * e);  // of floats
    EXPECT_LT(frame.stats.counted("reference standard error"), 1e-12);
}

TEST(Reference, FlatWaterUnderAPointAndASpot) {
    for (const bool spot : {false, true}) {
        scene::FrameState state = small_pool(4, 1, 2, 32);
        state.caustics.reference = kOneRound;
        scene::Light lamp;
        lamp.type = spot ? scene::LightType::spot : scene::LightType::point;
        lamp.position = {0.2, 1.5, 0.1};
        lamp.cone_angle = 35 * scene::kDegree;
        lamp.falloff_angle = 15 * scene::kDegree;
        state.lights = {lamp};
        const double n = state.water->refractive_index;
        const auto exact = [&](double x, double z) {
            const double r = std::hypot(x - 0.2, z - 0.1);
            return across_flat_water(1.5, 1, 1, n, r, [&](double in_air, double in_water) {
                double falloff = 1;
                if (spot) {
                    const double outer = std::cos(lamp.cone_angle);
                    const double inner = std::cos(lamp.cone_angle - lamp.falloff_angle);
                    const double t = std::clamp((1.5 / in_air - outer) / (inner - outer), 0.0, 1.0);
                    falloff = t * t * (3 - 2 * t);
                }
                return 10 * falloff * std::exp(-in_water * state.water->absorption.y);
            });
        };
        Frame frame(state);
        LayerResult result = frame.render();
        std::vector<double> expected = pixel_means(2, 32, exact);
        if (!spot) {
            expect_agreement(agreement(result, expected, 1));
            continue;
        }
        // The spot's edge: pixels with light in them have honest errors, dark ones are black.
        double error = 0, sum = 0, variance = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            error += static_cast<double>(result.irradiance[i].y) - expected[i];
            variance += static_cast<double>(result.data[1].values[i]);
            sum += expected[i];
            if (expected[i] == 0) {
                EXPECT_LT(result.irradiance[i].y, 1e-3f) << i;
            }
        }
        EXPECT_LT(std::abs(error), 3 * std::sqrt(variance));
        EXPECT_LT(std::sqrt(variance), 0.01 * sum);
    }
}

TEST(Reference, LampUnderFlatWaterLightsACeiling) {
    // T from below; what lies beyond the critical angle is reflected whole and must not come through.
    scene::FrameState state = small_pool(4, 1, 1, 32);
    state.objects = {test::level_plane("ceiling", 0.7, 10)};
    state.camera.position = {0, 0.3, 0};
    state.camera.target = {0, 1, 0};
    state.camera.up = {0, 0, 1};  // seen from below, with x to the left: the lamp is on the axis
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0, -0.8, 0};
    state.lights = {lamp};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    const LayerResult result = frame.render();
    const double n = state.water->refractive_index;
    expect_agreement(
        agreement(result,
                  pixel_means(1, 32,
                              [&](double x, double z) {
                                  return across_flat_water(
                                      0.8, 0.7, n, 1, std::hypot(x, z), [&](double in_water, double) {
                                          return 10 * std::exp(-in_water * state.water->absorption.z);
                                      });
                              }),
                  2));
}

constexpr double kSlopeLength = 0.5, kAmplitude = 0.01;

/// Pixel means of E below h = a cos(k x) under an overhead sun of unit irradiance, without absorption: the
/// landing point X = x + (d + h) tan(delta) is tabulated finely, its turns are found by bisection of dX/dx,
/// and between two of them the light between two edges of a pixel is what lies between the roots of X = edge,
/// found by bisection, with Simpson's rule for the transmittance.
std::vector<double> below_sinusoid(double depth, double index, double view, int pixels) {
    const double k = 2 * glm::pi<double>() / kSlopeLength;
    struct Ray {
        double landing, transmittance;
    };
    const auto ray = [&](double x) {
        const double tilt = std::atan(-kAmplitude * k * std::sin(k * x));
        const Refraction at = refract(tilt, 1, index);
        return Ray{x + (depth + kAmplitude * std::cos(k * x)) * std::tan(tilt - at.angle),
                   1 - at.reflectance};
    };
    const auto slope = [&](double x) { return ray(x + 1e-6).landing - ray(x - 1e-6).landing; };
    const auto bisect = [](double low, double high, const auto& below) {
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (below(middle) ? low : high) = middle;
        }
        return 0.5 * (low + high);
    };
    std::vector<double> turns{-1.5};
    constexpr int steps = 3000;
    for (int i = 0; i < steps; ++i) {
        const double a = -1.5 + 3.0 * i / steps, b = -1.5 + 3.0 * (i + 1) / steps;
        const bool rises = slope(a) > 0;
        if (rises != (slope(b) > 0))
            turns.push_back(bisect(a, b, [&](double x) { return (slope(x) > 0) == rises; }));
    }
    turns.push_back(1.5);
    std::vector<double> flux(static_cast<std::size_t>(pixels), 0);
    for (std::size_t t = 0; t + 1 < turns.size(); ++t) {
        const double from = turns[t], to = turns[t + 1];
        const bool rises = ray(to).landing > ray(from).landing;
        const auto root = [&](double edge) {
            return bisect(from, to, [&](double x) { return (ray(x).landing < edge) == rises; });
        };
        for (int pixel = 0; pixel < pixels; ++pixel) {
            const double a = root(view * (static_cast<double>(pixel) / pixels - 0.5));
            const double b = root(view * ((pixel + 1.0) / pixels - 0.5));
            flux[static_cast<std::size_t>(pixel)] +=
                std::abs(b - a) / 6 *
                (ray(a).transmittance + 4 * ray(0.5 * (a + b)).transmittance + ray(b).transmittance);
        }
    }
    for (double& value : flux) value *= pixels / view;
    return flux;
}

TEST(Reference, SinusoidBeforeAndBehindItsFocus) {
    for (const double depth : {1.27, 5.0}) {  // focus at 2.54 m
        scene::FrameState state = small_pool(3, depth, 1, 32);
        state.water->surface.waves.waves = {{kSlopeLength, 0, kAmplitude, 0}};
        state.water->absorption = glm::dvec3(0);
        state.water->extent.size = {3, 1.2};
        state.objects[0].size = {1, 1, 1};
        state.lights = {test::sun_from_zenith(0)};
        state.lights[0].irradiance = glm::dvec3(1);
        state.caustics.reference = kOneRound;
        Frame frame(state);
        const LayerResult result = frame.render();
        const std::vector<double> row = below_sinusoid(depth, state.water->refractive_index, 1, 32);
        std::vector<double> expected;
        for (int y = 0; y < 32; ++y) expected.insert(expected.end(), row.begin(), row.end());
        const Agreement a = agreement(result, expected);
        expect_agreement(a);
    }
}

}  // namespace
}  // namespace dapple
