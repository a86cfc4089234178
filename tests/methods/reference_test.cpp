// The brute-force reference against closed forms, and the honesty of its standard errors.
#include "methods/reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>

#include "base/checked_file.h"
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "image/temporary_folder.h"
#include "methods/reference/deposit_cells.h"
#include "methods/reference/progress_file.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/sine_sum.h"
#include "methods/reference/true_surface.h"
#include "ocean/water_surface.h"
#include "scene/transform.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

using methods::LayerResult;
using methods::Reference;

/// A frame on its way through the method, without the rest of the program.
struct Frame {
    scene::FrameScene scene;
    std::optional<rays::RayScene> rays;
    FrameStats stats;
    std::vector<light::Chain> chains{{0, light::Event::transmission}};
    methods::Checkpoint checkpoint;
    reference::ReferenceOptions options;

    explicit Frame(const scene::FrameState& state) {
        scene.state = state;
        scene.object_meshes.resize(state.objects.size());
        scene.water =
            std::make_shared<const scene::WaterMesh>(ocean::WaterSurface(*state.water).mesh(state.time));
    }
    LayerResult render() {
        rays.emplace(scene);
        view::LayerCounts counts;
        const view::ReceiverLayer layer = view::trace_layer(scene, *rays, {}, counts);
        methods::FrameContext context{scene, *rays, test::validated_device(), stats, chains, checkpoint};
        Reference method(options);
        method.begin(context);
        LayerResult result;
        method.irradiance(context, std::span(&layer, 1), std::span(&result, 1));
        return result;
    }
};

/// What a picture says of a closed form: errors over the reference's own standard errors.
struct Agreement {
    double worst = 0;        ///< largest |t| of a pixel
    double mean = 0;         ///< error of the mean over the pixels, in standard errors of independent pixels
    double mean_square = 0;  ///< of t
    double relative_mean = 0;  ///< error of the mean
    std::size_t pixels = 0;
};

Agreement agreement(const LayerResult& result, const std::vector<double>& expected, int channel = 0) {
    Agreement a;
    double error = 0, variance = 0, sum = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const double difference = static_cast<double>(result.irradiance[i][channel]) - expected[i];
        const auto var = static_cast<double>(result.data[static_cast<std::size_t>(channel)].values[i]);
        const double t = difference / std::sqrt(var);
        a.worst = std::max(a.worst, std::abs(t));
        a.mean_square += t * t / static_cast<double>(expected.size());
        error += difference;
        variance += var;
        sum += expected[i];
    }
    a.pixels = expected.size();
    a.mean = error / std::sqrt(variance);
    a.relative_mean = error / sum;
    printf("worst |t| %.2f, mean %.2f standard errors (%.1e), mean t^2 %.3f\n", a.worst, a.mean,
           a.relative_mean, a.mean_square);
    return a;
}

/// t of a pixel's mean over 16 passes has 15 degrees of freedom: |t| exceeds this once in a million.
constexpr double kWorstT = 7.6;
/// Mean square of such t, and its standard deviation.
constexpr double kMeanSquareT = 15.0 / 13, kSpreadOfSquareT = 1.84;

void expect_agreement(const Agreement& a) {
    EXPECT_LT(a.worst, kWorstT);
    EXPECT_LT(std::abs(a.mean), 3);
    EXPECT_NEAR(a.mean_square, kMeanSquareT, 5 * kSpreadOfSquareT / std::sqrt(a.pixels));
}

scene::FrameState small_pool(double patch, double depth, double view, int pixels) {
    scene::FrameState state = test::pool_over_floor(patch, depth, view, pixels);
    state.caustics.method = "reference";
    state.caustics.reference = {0.02, 100};
    return state;
}

/// Standard error so large that the first round, a million rays a light, is the answer.
constexpr scene::ReferenceParameters kOneRound{1e9, 1};

/// Mean of `value` over each pixel of a square picture of `view` m, by 4 x 4 points; x to the right and z
/// down from the middle.
std::vector<double> pixel_means(double view, int pixels, const std::function<double(double, double)>& value) {
    std::vector<double> means;
    constexpr int points = 4;
    for (int i = 0; i < pixels * pixels; ++i) {
        double sum = 0;
        for (int k = 0; k < points * points; ++k) {
            const int row = i / pixels, part = k / points;
            const double x = i % pixels + (k % points + 0.5) / points;
            const double z = row + (part + 0.5) / points;
            sum += value(view * (x / pixels - 0.5), view * (z / pixels - 0.5));
        }
        means.push_back(sum / (points * points));
    }
    return means;
}

/// Reflectance and angle of refraction from angles, as in textbooks.
struct Refraction {
    double angle, reflectance;
};
Refraction refract(double angle, double index_from, double index_to) {
    const double inside = std::asin(index_from / index_to * std::sin(angle));
    if (std::abs(angle) < 1e-5)
        return {inside, std::pow((index_from - index_to) / (index_from + index_to), 2)};
    const double s = std::sin(angle - inside) / std::sin(angle + inside);
    const double p = std::tan(angle - inside) / std::tan(angle + inside);
    return {inside, 0.5 * (s * s + p * p)};
}

/// E on a level plane on the other side of flat water, at the distance `r` from the foot of a lamp of unit
/// intensity: `a` m from lamp to water, `b` m from water to plane; I (1 - F) sin(t_i) / (r dr/dt_i), by
/// bisection for t_i. `way` takes the length on either side.
double across_flat_water(double a, double b, double index_from, double index_to, double r,
                         const std::function<double(double, double)>& along_way) {
    double low = 0, high = index_from > index_to ? std::asin(index_to / index_from) : 0.5 * glm::pi<double>();
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        const double inside = refract(middle, index_from, index_to).angle;
        (a * std::tan(middle) + b * std::tan(inside) < r ? low : high) = middle;
    }
    const Refraction at = refract(low, index_from, index_to);
    const double c = std::cos(low), ct = std::cos(at.angle);
    const double spread = a / (c * c) + b * c * index_from / (index_to * ct * ct * ct);
    return (1 - at.reflectance) * std::sin(low) / (r * spread) * along_way(a / c, b / ct);
}

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

/// Light that the water transmits, per unit of the sun's irradiance, for waves along x and a sun at -x: a
/// fine grid, whose points are hidden where an earlier one reaches higher above the slope of the light.
struct Transmitted {
    double lit, all;  ///< with and without shadows
};
Transmitted transmitted_flux(const scene::Water& water, const glm::dvec3& direction) {
    const ocean::WaterSurface surface(water);
    const double climb = -direction.y / direction.x;
    constexpr int steps = 200000;
    Transmitted sum{0, 0};
    double horizon = -1e9;
    for (int i = 0; i < steps; ++i) {
        const double x = water.extent.size.x * ((i + 0.5) / steps - 0.5);
        const ocean::SurfaceSample at = surface.sample(x, 0, 0);
        const glm::dvec3 normal(-at.slope.x, 1, -at.slope.y);
        const double facing = -dot(direction, normal);
        const bool hidden = at.height + climb * x < horizon;
        horizon = std::max(horizon, at.height + climb * x);
        if (facing <= 0) continue;
        const double angle = std::acos(std::min(1.0, facing / length(normal)));
        const double flux = facing * (1 - refract(angle, 1, water.refractive_index).reflectance);
        sum.all += flux;
        if (!hidden) sum.lit += flux;
    }
    const double cell = water.extent.size.x * water.extent.size.y / steps;
    return {cell * sum.lit, cell * sum.all};
}

/// All that lands on a floor that catches everything, over the flux that comes in; and the standard error.
struct Catch {
    double share, error;
};
Catch caught(Frame& frame, double flux) {
    const scene::FrameState& state = frame.scene.state;
    const LayerResult result = frame.render();
    const double pixel = std::pow(state.camera.view_height / state.clip.height, 2);
    double sum = 0, variance = 0;
    for (std::size_t i = 0; i < result.irradiance.size(); ++i) {
        sum += static_cast<double>(result.irradiance[i].x);
        variance += static_cast<double>(result.data[0].values[i]);
    }
    return {pixel * sum / flux, pixel * std::sqrt(variance) / flux};
}

TEST(Reference, CatchesAllTransmittedLight) {
    scene::FrameState state = small_pool(1, 0.5, 2, 64);
    state.objects[0].size = {2, 1, 2};
    state.water->absorption = glm::dvec3(0);
    state.water->surface.waves.waves = {{0.4, 0, 0.012, 0.3}, {0.23, 0, 0.005, 1.1}};
    state.lights = {test::sun_from_zenith(40)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    const double flux = transmitted_flux(*state.water, state.lights[0].direction).all;
    Frame frame(state);
    const Catch found = caught(frame, flux);
    printf("caught %.6f +- %.6f\n", found.share, found.error);
    // The landing points of neighbouring strata share out between pixels: their errors cancel in the sum,
    // which is nearer than its standard error for independent pixels says.
    EXPECT_NEAR(found.share, 1, 3 * found.error);
    EXPECT_NEAR(found.share, 1, 1e-4);

    // The same surface as the triangles of a file, 3.3 mm wide.
    state.water->mesh_cells = 300;
    Frame read(state);
    read.scene.state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
    const Catch on_triangles = caught(read, flux);
    printf("caught from triangles %.6f +- %.6f\n", on_triangles.share, on_triangles.error);
    EXPECT_NEAR(on_triangles.share, 1, 1e-4 + 3 * on_triangles.error);
}

TEST(Reference, CatchesTheLightOfASpectrum) {
    // The pool ends between pixels, since those count the receivers of one medium only.
    scene::FrameState state = small_pool(2, 0.5, 4, 64);
    state.objects[0].size = {4, 1, 4};
    state.camera.position.y = -0.4;  // below all troughs
    state.water->absorption = glm::dvec3(0);
    state.water->surface.type = scene::WaterSurfaceType::spectrum;
    state.water->surface.spectrum.wind_speed = 2;
    state.water->surface.spectrum.cutoff_length = 0.25;
    state.lights = {test::sun_from_zenith(40)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    Frame frame(state);
    // The sea is periodic, so that the mean over the points of its grid is an integral.
    const ocean::SurfaceGrid grid = ocean::WaterSurface(*state.water).grid(0, ocean::kSlope);
    double flux = 0, steepest = 0;
    for (int row = 0; row + 1 < grid.rows; ++row) {
        for (int column = 0; column + 1 < grid.columns; ++column) {
            const auto at = static_cast<std::size_t>(row * grid.columns + column);
            const glm::dvec3 normal(-grid[ocean::Field::slope_x][at], 1, -grid[ocean::Field::slope_z][at]);
            const double facing = -dot(state.lights[0].direction, normal);
            const double angle = std::acos(std::min(1.0, facing / length(normal)));
            flux += facing * (1 - refract(angle, 1, state.water->refractive_index).reflectance);
            steepest = std::max(steepest, std::hypot(normal.x, normal.z));
        }
    }
    ASSERT_GT(steepest, 0.1);  // it has waves, which the camera does not meet
    ASSERT_LT(frame.scene.water->largest_height, 0.3);
    flux *= 4.0 / ((grid.rows - 1) * (grid.columns - 1));
    const Catch found = caught(frame, flux);
    printf("caught %.6f +- %.6f\n", found.share, found.error);
    EXPECT_NEAR(found.share, 1, 3 * found.error);
    EXPECT_NEAR(found.share, 1, 1e-4);
}

TEST(Reference, WavesShadowEachOther) {
    // A sun 8 degrees high over slopes of up to 0.38: a third of the water lies in shadow.
    scene::FrameState state = small_pool(1, 0.5, 4, 64);
    state.objects[0].size = {4, 1, 4};
    state.water->absorption = glm::dvec3(0);
    state.water->surface.waves.waves = {{0.25, 0, 0.015, 0.3}};
    state.lights = {test::sun_from_zenith(82)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    const Transmitted exact = transmitted_flux(*state.water, state.lights[0].direction);
    EXPECT_LT(exact.lit, 0.8 * exact.all);
    Frame frame(state);
    const Catch found = caught(frame, exact.lit);
    printf("caught %.5f +- %.5f of %.3f\n", found.share, found.error, exact.lit / exact.all);
    EXPECT_NEAR(found.share, 1, 3 * found.error);
}

TEST(Reference, MirrorUnderWater) {
    // Straight down onto a mirror at 45 degrees, and along the water to a wall: 2 m of way everywhere.
    scene::FrameState state = small_pool(2, 5, 0.4, 32);
    scene::Object mirror = test::level_plane("mirror", -1, 1);
    mirror.transform.rotation.z = 45 * scene::kDegree;
    mirror.material = {{0.9, 0.8, 0.7}, "", 1, true};
    scene::Object wall = test::level_plane("wall", -1, 3);
    wall.transform.position.x = -1;
    wall.transform.rotation.z = -90 * scene::kDegree;
    state.objects = {mirror, wall};
    state.camera.position = {-0.8, -1, 0};
    state.camera.target = {-1, -1, 0};
    state.camera.up = {0, 1, 0};
    state.lights = {test::sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    const test::FlatFloor exact = test::flat_floor(0, 2, state.water->refractive_index);
    Frame frame(state);
    const LayerResult result = frame.render();
    for (int channel = 0; channel < 3; ++channel) {
        const double e = state.lights[0].irradiance[channel] * exact.irradiance *
                         mirror.material.color[channel] * std::exp(-2 * state.water->absorption[channel]);
        expect_agreement(agreement(result, std::vector<double>(1024, e), channel));
    }
    frame.options.mirrors = false;
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(Reference, SecondCrossing) {
    // Reflected by the water, by a mirror over it, and refracted on its way back: to the floor. The sun's
    // own refracted light is not asked for.
    scene::FrameState state = small_pool(8, 1, 0.6, 16);
    state.water->extent = {scene::ExtentKind::pool, {0.9, 0}, {4, 1}};
    scene::Object mirror = test::level_plane("mirror", 1, 1.5);
    mirror.transform.position.x = 0.75;
    mirror.material = {{0.9, 0.8, 0.7}, "", 1, true};
    state.objects.push_back(mirror);
    state.camera.position.x = state.camera.target.x = 2.3;
    state.lights = {test::sun_from_zenith(45)};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    frame.chains = {{0, light::Event::reflection}};
    const Refraction at = refract(glm::radians(45.0), 1, state.water->refractive_index);
    const double e = 3 * std::cos(glm::radians(45.0)) * at.reflectance * 0.9 * (1 - at.reflectance) *
                     std::exp(-state.water->absorption.x / std::cos(at.angle));
    expect_agreement(agreement(frame.render(), std::vector<double>(256, e)));
    frame.options.second_crossings = false;
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(Reference, DispersionLandsColoursApart) {
    // Over flat water only the transmittance tells the indices apart, a little; the channels get their own.
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.objects[0].size = {1, 1, 1};
    state.water->dispersion = 0.2;
    state.water->absorption = glm::dvec3(0);
    state.lights = {test::sun_from_zenith(60)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    Frame frame(state);
    const LayerResult result = frame.render();
    for (int channel = 0; channel < 3; ++channel) {
        const double n = state.water->refractive_index + 0.1 * (channel - 1);
        expect_agreement(
            agreement(result, std::vector<double>(256, test::flat_floor(60, 1, n).irradiance), channel));
    }
}

TEST(Reference, MeshReceivesWhatItsPlaneDoes) {
    scene::FrameState state = small_pool(3, 1, 1, 32);
    state.objects[0].shape = scene::Shape::mesh;
    state.objects[0].transform.position.y = -1;
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    // A fan of slivers and wide triangles about a point off the middle.
    auto mesh = std::make_shared<scene::TriangleMesh>();
    mesh->positions = {{0.13, 0, 0.21}};
    constexpr glm::uint spokes = 17;
    for (glm::uint i = 0; i < spokes; ++i) {
        const double angle = -2 * glm::pi<double>() * std::pow(static_cast<double>(i) / spokes, 1.5);
        mesh->positions.push_back({3 * std::cos(angle), 0, 3 * std::sin(angle)});
        mesh->triangles.push_back({0, i + 1, (i + 1) % spokes + 1});
    }
    frame.scene.object_meshes[0] = mesh;
    const test::FlatFloor exact = test::flat_floor(35, 1, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    expect_agreement(agreement(frame.render(), std::vector<double>(1024, e)));
}

TEST(Reference, SeenFromAboveInPerspective) {
    // E of the floor is the same everywhere, whatever the size of the pixels on it: cells from near to far.
    scene::FrameState state = small_pool(5, 1, 1, 32);
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {0, 0.6, 2.2};
    state.camera.target = {0, -1, 0};
    state.camera.up = {0, 1, 0};
    state.camera.field_of_view = 40 * scene::kDegree;
    state.lights = {test::sun_from_zenith(20)};
    state.caustics.reference = kOneRound;
    const test::FlatFloor exact = test::flat_floor(20, 1, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    expect_agreement(agreement(Frame(state).render(), std::vector<double>(1024, e)));
}

TEST(Reference, WallsHaveTwoSides) {
    // A level plate in the water: light from above is on its upper side, and its lower side is dark.
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.lights = {test::sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    EXPECT_GT(Frame(state).render().irradiance[100].x, 1);
    state.camera.position.y = -2;
    state.camera.target.y = 0;
    for (const glm::vec3& dark : Frame(state).render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(Reference, ResumesToTheSameBits) {
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.water->surface.waves.waves = {{0.5, 0.3, 0.01, 0}};
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = {0.05, 4};
    const LayerResult whole = Frame(state).render();

    const test::TemporaryFolder folder;
    Frame broken(state);
    broken.checkpoint.file = folder / "progress";
    int calls = 0, interruptions = 0;
    broken.checkpoint.stop = [&] { return ++calls % 6 == 0; };
    std::optional<LayerResult> resumed;
    while (!resumed && interruptions < 100) {
        try {
            resumed = broken.render();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::interrupted);
            ++interruptions;
        }
    }
    ASSERT_TRUE(resumed);
    EXPECT_GT(interruptions, 2);
    EXPECT_EQ(resumed->irradiance, whole.irradiance);
    EXPECT_EQ(resumed->data[0].values, whole.data[0].values);

    // A finished file gives the answer without a ray; another job does not take it.
    broken.stats = {};
    broken.checkpoint.stop = [] { return false; };
    EXPECT_EQ(broken.render().irradiance, whole.irradiance);
    EXPECT_EQ(broken.stats.counted("reference rays"), 0);
    broken.scene.state.clip.seed = 1;
    EXPECT_NE(broken.render().irradiance, whole.irradiance);
}

TEST(Reference, ForgetsDamagedProgress) {
    const test::TemporaryFolder folder;
    reference::Progress progress;
    progress[{0, 1}].start(64, 3);
    progress[{0, 1}].add_pass({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}});
    const std::string path = folder / "progress";
    reference::write_progress(path, "job", progress);
    ASSERT_EQ(reference::read_progress(path, "job").size(), 1u);
    EXPECT_EQ((reference::read_progress(path, "job")[{0, 1}].mean), (progress[{0, 1}].mean));
    EXPECT_TRUE(reference::read_progress(path, "another job").empty());
    EXPECT_TRUE(reference::read_progress(folder / "none", "job").empty());
    std::vector<std::byte> bytes = read_whole_file(path);
    bytes[bytes.size() / 2] ^= std::byte{1};
    write_file_atomically(path, bytes);
    EXPECT_TRUE(reference::read_progress(path, "job").empty());
    bytes.resize(10);
    write_file_atomically(path, bytes);
    EXPECT_TRUE(reference::read_progress(path, "job").empty());
}

TEST(Reference, SameBitsOnAnyNumberOfThreadsAndInAnyBatch) {
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.clip.samples = 2;
    state.water->surface.waves.waves = {{0.5, 0.3, 0.01, 0}};
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    set_thread_count(1);
    const LayerResult one = Frame(state).render();
    set_thread_count(2);
    EXPECT_EQ(Frame(state).render().irradiance, one.irradiance);
    set_thread_count(0);

    Frame frame(state);
    frame.rays.emplace(frame.scene);
    std::vector<view::ReceiverLayer> layers;
    for (const int sample : {1, 0}) {
        view::LayerCounts counts;
        layers.push_back(view::trace_layer(frame.scene, *frame.rays, {sample, 0}, counts));
    }
    methods::FrameContext context{frame.scene, *frame.rays,  test::validated_device(),
                                  frame.stats, frame.chains, {}};
    Reference method;
    method.begin(context);
    std::vector<LayerResult> results(2);
    method.irradiance(context, layers, results);
    EXPECT_EQ(results[1].irradiance, one.irradiance);
    EXPECT_TRUE(results[0].data.empty());
}

TEST(Reference, SumOfSinesIsThatOfTheSea) {
    scene::Water water;
    water.surface.waves.depth = 3;
    for (int i = 0; i < 24; ++i) {
        const double length = 0.15 * std::pow(8, i / 23.0);
        water.surface.waves.waves.push_back({length, 2.4 * i, 0.003 * length, 1.7 * i});
    }
    const ocean::WaterSurface sea(water);
    const reference::SineSum sum(water.surface.waves, 12.34);
    std::vector<double> x, z;
    for (int i = 0; i < 1000; ++i) {
        x.push_back(20 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 0) - 10);
        z.push_back(20 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 1) - 10);
    }
    std::vector<double> h(1000), sx(1000), sz(1000);
    sum.evaluate(x, z, h, sx, sz);
    for (std::size_t i = 0; i < 1000; ++i) {
        const ocean::SurfaceSample exact = sea.sample(x[i], z[i], 12.34);
        ASSERT_NEAR(h[i], exact.height, 1e-12);
        ASSERT_NEAR(sx[i], exact.slope.x, 1e-12);
        ASSERT_NEAR(sz[i], exact.slope.y, 1e-12);
    }
}

TEST(Reference, PatchesOfASeaAreNearlyExact) {
    scene::FrameState state = small_pool(1, 1, 1, 1);
    state.water->extent.size = {6, 4};
    state.water->surface.type = scene::WaterSurfaceType::spectrum;
    state.water->surface.spectrum.cutoff_length = 0.5;
    state.time = 3;
    scene::FrameScene scene;
    scene.state = state;
    const reference::TrueSurface surface(scene);
    const ocean::WaterSurface sea(*state.water);
    double largest = 0, height_error = 0, largest_slope = 0, slope_error = 0;
    for (int i = 0; i < 300; ++i) {
        const double x = 6 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 0) - 3;
        const double z = 4 * hash_uniform(1, 0, static_cast<std::uint64_t>(i), 1) - 2;
        double h = 0, sx = 0, sz = 0;
        surface.evaluate({&x, 1}, {&z, 1}, {&h, 1}, {&sx, 1}, {&sz, 1});
        const ocean::SurfaceSample exact = sea.sample(x, z, 3);
        largest = std::max(largest, std::abs(exact.height));
        largest_slope = std::max(largest_slope, length(exact.slope));
        height_error = std::max(height_error, std::abs(h - exact.height));
        slope_error = std::max(slope_error, length(glm::dvec2(sx, sz) - exact.slope));
        EXPECT_LT(length(exact.slope), surface.steepest());
    }
    printf("height %.1e of %.1e, slope %.1e of %.1e\n", height_error, largest, slope_error, largest_slope);
    // 100 cells a shortest wave: (k cell)^4 / 384 = 4e-8 and (k cell)^3 / 125 = 2e-6 of its own share.
    EXPECT_LT(height_error, 1e-7 * largest);
    EXPECT_LT(slope_error, 2e-6 * largest_slope);
}

TEST(Reference, ChartsOfSpheresHaveTheirAreas) {
    scene::FrameState state;
    scene::Object ball;
    ball.shape = scene::Shape::sphere;
    ball.radius = 0.5;
    ball.transform.position = {1, 2, 3};
    ball.transform.rotation = {0.3, 0.4, 0.5};
    for (const glm::dvec3 scale : {glm::dvec3(2), glm::dvec3(1, 0.3, 2)}) {
        ball.transform.scale = scale;
        scene::FrameScene scene;
        scene.state.objects = {ball};
        const reference::ReceiverCharts charts(scene);
        const glm::dmat4 world = scene::world_from_object(ball.transform);
        const auto point = [&](double longitude, double latitude) {
            const glm::dvec3 unit(std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                                  std::cos(latitude) * std::sin(longitude));
            return glm::dvec3(world * glm::dvec4(0.5 * unit, 1));
        };
        // A fine grid of quadrangles: area over density gives the measure of each of 64 cells, on the
        // outside.
        std::map<std::uint64_t, double> measure;
        constexpr int across = 1024, up = 512;
        for (int i = 0; i < across; ++i) {
            for (int j = 0; j < up; ++j) {
                const double step = glm::pi<double>() / up;
                const double longitude = i * step, latitude = (j - 0.5 * up) * step;
                const glm::dvec3 a = point(longitude, latitude), b = point(longitude + step, latitude),
                                 c = point(longitude, latitude + step),
                                 d = point(longitude + step, latitude + step);
                const glm::dvec3 middle = point(longitude + 0.5 * step, latitude + 0.5 * step);
                const reference::ChartPlace place =
                    charts.place(0, 0, middle, middle - ball.transform.position);
                measure[place.key >> (2 * (charts.digits() - 3))] +=
                    0.5 * length(cross(d - a, c - b)) / place.density;
            }
        }
        ASSERT_EQ(measure.size(), 64u);
        // Rows of quadrangles straddle the edges between cells: up to 1 part in 200 of a cell near the poles.
        for (const auto& [cell, sum] : measure) EXPECT_NEAR(sum, 1.0 / 64, 0.01 / 64) << cell;
        // The inside is another chart.
        const glm::dvec3 some = point(0.2, 0.3);
        EXPECT_NE(charts.place(0, 0, some, some - ball.transform.position).key,
                  charts.place(0, 0, some, ball.transform.position - some).key);
    }
}

TEST(Reference, CellsFollowThePaths) {
    // 64 x 64 paths in the middle quarter of a chart, one a cell; and one far off.
    std::vector<reference::PathEnd> ends;
    const auto key = [](std::uint64_t x, std::uint64_t y, int level) {
        std::uint64_t digits = 0;
        for (int i = level - 1; i >= 0; --i) digits = digits << 2 | (x >> i & 1) | (y >> i & 1) << 1;
        return digits << (2 * (30 - level)) | std::uint64_t{1} << (2 * (29 - level));
    };
    for (std::uint32_t i = 0; i < 4096; ++i) ends.push_back({key(64 + i % 64, 64 + i / 64, 8), i});
    const reference::DepositCells cells(ends, 1, 30);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const auto cell = cells.find(key(64 + i % 64, 64 + i / 64, 8));
        ASSERT_EQ(cell.per_measure, std::pow(4.0, 8));
        ASSERT_EQ(std::vector(cell.pixels.begin(), cell.pixels.end()), std::vector{i});
    }
    EXPECT_TRUE(cells.find(key(63, 64, 8)).pixels.empty());
    EXPECT_TRUE(cells.find(key(200, 3, 8)).pixels.empty());
    // The order of the paths does not matter, and paths that end in one point share a cell.
    std::reverse(ends.begin(), ends.end());
    ends.push_back(ends.front());
    const auto shared = reference::DepositCells(ends, 1, 30).find(ends.front().key);
    EXPECT_EQ(shared.pixels.size(), 2u);
}

}  // namespace
}  // namespace dapple
