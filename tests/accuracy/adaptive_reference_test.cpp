// E and S of adaptive_beams as pictures against the method `reference`, as beams are refined: below waves,
// below a ball of glass, and below a ball above waves. The references are made here; their own noise is
// printed. Compiled twice: with DAPPLE_LONG for the settings that take longer.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "accuracy/scenes.h"
#include "gpu/validated_device.h"
#include "methods/registry.h"

namespace dapple {
namespace {

using light::Event;

/// A small picture of what one kind of light does in a frame.
struct Case {
    scene::FrameState state;
    std::vector<light::Chain> chains;
};

/// Means over pixels, green.
struct Means {
    std::vector<double> value;     ///< E, W/m^2, or S, W/m^2/sr
    std::vector<double> covered;   ///< share of a pixel that has E
    std::vector<double> variance;  ///< of the reference
    double beams = 0;
};

std::vector<double> values_of(const std::vector<methods::DataLayer>& data, const std::string& name) {
    for (const methods::DataLayer& layer : data)
        if (layer.name == name) return {layer.values.begin(), layer.values.end()};
    return {};
}

/// Of a picture whose pixels are `finer` times smaller, one sample each, the means over the case's pixels.
Means take(const Case& c, const std::string& name, int finer, bool scattered) {
    scene::FrameState state = c.state;
    state.clip.samples = 1;
    state.clip.width *= finer;
    state.clip.height *= finer;
    const scene::FrameScene scene = [&] {
        if (state.water) return test::scene_of(state);
        scene::FrameScene without;
        without.state = state;
        without.object_meshes.resize(state.objects.size());
        return without;
    }();
    const rays::RayScene rays(scene);
    FrameStats stats;
    methods::FrameContext context{scene, rays, test::validated_device(), stats, c.chains, {}};
    const std::unique_ptr<methods::CausticMethod> method = methods::make_method(name);
    method->begin(context);
    view::LayerCounts counts;
    view::SegmentLayer segments;
    const view::ReceiverLayer layer =
        view::trace_layer(scene, rays, {}, counts, scattered ? &segments : nullptr);
    const std::size_t pixels = layer.pixels();
    std::vector<double> values(pixels, 0), covered(pixels, 1);
    Means means;
    if (scattered) {
        std::vector<glm::vec3> radiance(segments.segments(), glm::vec3(0));
        method->in_scatter(context, segments, radiance);
        for (std::size_t pixel = 0; pixel < pixels; ++pixel)
            for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i)
                values[pixel] += static_cast<double>(segments.throughput[i].g * radiance[i].g);
        means.variance = values_of(method->in_scatter_data(), "S.variance.G");
    } else {
        methods::LayerResult result;
        result.irradiance.assign(pixels, glm::vec3(0));
        result.covered.assign(pixels, 0);
        method->irradiance(context, std::span(&layer, 1), std::span(&result, 1));
        for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
            values[pixel] = static_cast<double>(result.irradiance[pixel].g);
            covered[pixel] = static_cast<double>(result.covered[pixel]);
        }
        means.variance = values_of(result.data, "E.variance.G");
    }
    const auto width = static_cast<std::size_t>(c.state.clip.width), k = static_cast<std::size_t>(finer);
    means.value.assign(pixels / (k * k), 0);
    means.covered.assign(means.value.size(), 0);
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::size_t x = i % (width * k), y = i / (width * k), to = y / k * width + x / k;
        means.value[to] += values[i] / static_cast<double>(k * k);
        means.covered[to] += covered[i] / static_cast<double>(k * k);
    }
    means.beams = stats.counted("beams");
    return means;
}

scene::FrameState small_picture(scene::FrameState state) {
    state.clip.width = 48;
    state.clip.height = 27;
    state.caustics.reference = {0.02, 40};
    return state;
}

/// A floor below waves past their first folds, seen by an eye in the water.
scene::FrameState wavy_pool(double depth = test::kFloorDepth) {
    scene::FrameState state = small_picture(test::waves_over_floor(16, {-0.5, 0}, {2.5, 2.5}, 48));
    state.camera.position = {-0.9, -0.3 * depth, 1.2};
    state.camera.target = {0.3, -depth, 0};
    state.camera.field_of_view = 24 * scene::kDegree;
    state.water->absorption = glm::dvec3(0.05);
    state.objects.push_back(test::floor_plane({0, -depth, 0}));
    return state;
}

scene::Object glass_ball(glm::dvec3 middle, double radius) {
    scene::Object ball;
    ball.name = "ball";
    ball.shape = scene::Shape::sphere;
    ball.radius = radius;
    ball.transform.position = middle;
    ball.material.glass = true;
    ball.material.refractive_index = 1.5;
    ball.material.absorption = glm::dvec3(0.1);
    return ball;
}

struct Row {
    double l1 = 0, bias = 0, noise = 0, beams = 0;
};

/// A setting of the method: cells of its grid, levels, and how many times finer than the case's its own
/// pixels are: by these it knows where it need not refine, and S of its samples is that of rays.
struct Setting {
    int grid, levels, finer;
};

/// A row of figures a setting, over the pixels that both methods cover.
std::vector<Row> rows(const char* title, Case c, const std::vector<Setting>& settings, bool scattered) {
    const double start = wall_seconds();
    const Means truth = take(c, "reference", 1, scattered);
    const double made = wall_seconds() - start;
    std::vector<Row> result;
    for (const Setting& setting : settings) {
        c.state.caustics.adaptive_beams.grid = setting.grid;
        c.state.caustics.adaptive_beams.levels = setting.levels;
        const double begin = wall_seconds();
        const Means beams = take(c, "adaptive_beams", setting.finer, scattered);
        const double took = wall_seconds() - begin;
        double sum = 0, error = 0, difference = 0, noise = 0;
        std::size_t pixels = 0;
        for (std::size_t i = 0; i < truth.value.size(); ++i) {
            if (beams.covered[i] < 1 || truth.covered[i] < 1) continue;
            ++pixels;
            sum += truth.value[i];
            error += std::abs(beams.value[i] - truth.value[i]);
            difference += beams.value[i] - truth.value[i];
            noise += std::sqrt(2 / std::numbers::pi * truth.variance[i]);
        }
        if (result.empty())
            printf("%s: %zu pixels, reference's noise %.4f, made in %.1f s\n", title, pixels, noise / sum,
                   made);
        result.push_back({error / sum, difference / sum, noise / sum, beams.beams});
        printf("  grid %3d, %d levels, pixels %d times finer: L1 %.4f, bias %+.4f, %6.0f beams, %.2f s\n",
               setting.grid, setting.levels, setting.finer, result.back().l1, result.back().bias, beams.beams,
               took);
    }
    return result;
}

#if !DAPPLE_LONG  // no longer rows
TEST(AdaptiveBeams, IrradianceBelowWaves) {
    const std::vector<Row> r =
        rows("waves", {wavy_pool(), {{0, Event::transmission}}}, {{16, 0, 1}, {16, 2, 1}, {16, 4, 1}}, false);
    // Cells of 16, 4 and 1 cm below waves of 50 cm to 1 m: the first know little of them.
    EXPECT_LT(r[1].l1, 0.3 * r[0].l1);
    EXPECT_LT(r[2].l1, r[1].l1);
    // Not much more than the reference's noise; points of 64 places a pixel are off by 6 %.
    EXPECT_LT(r[2].l1, 2.2 * r[2].noise);
    EXPECT_LT(std::abs(r[2].bias), 0.005);
}

TEST(AdaptiveBeams, ScatteredLightBelowWaves) {
    Case c{wavy_pool(), {{0, Event::transmission}}};
    c.state.water->scattering = glm::dvec3(0.1);
    c.state.water->phase.type = scene::PhaseType::henyey_greenstein;
    c.state.water->phase.anisotropy = 0.6;
    const std::vector<Row> r = rows("murky waves", c, {{16, 0, 4}, {16, 2, 4}, {16, 4, 4}}, true);
    EXPECT_LT(r[1].l1, 0.3 * r[0].l1);
    EXPECT_LT(r[2].l1, r[1].l1);
    // Nearly all of it is the reference's noise.
    EXPECT_LT(r[2].l1, 1.5 * r[2].noise);
    EXPECT_LT(std::abs(r[2].bias), 0.005);
}
#endif

TEST(AdaptiveBeams, IrradianceBelowABall) {
    Case c{small_picture({}), {{0, Event::transmission, 1}}};
    c.state.objects = {test::floor_plane({0, 0, 0}), glass_ball({0, 0.8, 0}, 0.4)};
    c.state.lights = {test::point_like_sun(60)};
    c.state.camera.position = {1.6, 0.7, 1.2};
    c.state.camera.target = {0.46, 0, 0};
    c.state.camera.field_of_view = 30 * scene::kDegree;
    std::vector<Setting> settings = {{16, 0, 1}, {16, 1, 1}, {16, 2, 1}, {16, 4, 1}, {128, 0, 1}};
    if (DAPPLE_LONG) settings = {{16, 3, 1}, {16, 5, 1}, {64, 0, 1}, {256, 0, 1}};
    const std::vector<Row> r = rows("ball", c, settings, false);
    if (DAPPLE_LONG) {
        // Levels beyond the second go to outlines; within, landing points are right to a pixel.
        EXPECT_NEAR(r[0].l1, r[1].l1, 0.01);
        EXPECT_LT(r[3].l1, r[2].l1);
        EXPECT_LT(r[3].l1, 1.4 * r[3].noise);
        return;
    }
    for (std::size_t i = 1; i < 3; ++i) EXPECT_LT(std::abs(r[i].bias), std::abs(r[i - 1].bias));
    // Corners beside a fold have beams of both of its sides in their rings, which are even on neither.
    EXPECT_LT(std::abs(r[3].bias), 0.003);
    EXPECT_LT(r[2].l1, 0.5 * r[0].l1);
    // Landing points are taken to be good where they are right to a twentieth of a pixel: in the core of the
    // light some per cent are left of E, whatever the levels.
    EXPECT_LT(r[3].l1, 2 * r[3].noise);
    // With small cells everywhere little but the reference's noise is left.
    EXPECT_LT(r[4].l1, 1.5 * r[4].noise);
    EXPECT_LT(std::abs(r[4].bias), 0.01);
}

#if !DAPPLE_LONG
TEST(AdaptiveBeams, ScatteredLightBelowABallAboveWaves) {
    Case c{wavy_pool(1), {{0, Event::transmission, 1}}};
    c.state.camera.target = {0, -0.7, 0};
    c.state.camera.field_of_view = 40 * scene::kDegree;
    c.state.water->scattering = glm::dvec3(0.1);
    c.state.objects.push_back(glass_ball({-0.5, 0.6, 0}, 0.3));
    c.state.caustics.reference = {0.06, 2};
    const std::vector<Row> r =
        rows("murky waves below a ball", c, {{16, 0, 2}, {16, 1, 2}, {16, 3, 2}}, true);
    // The ball's light narrows to a focus that few cells know little of.
    EXPECT_LT(r[1].l1, 0.6 * r[0].l1);
    EXPECT_LT(std::abs(r[1].bias), 0.5 * std::abs(r[0].bias));
    EXPECT_LT(r[2].l1, 1.5 * r[2].noise);
    EXPECT_LT(std::abs(r[2].bias), 0.015);
}
#endif

TEST(AdaptiveBeams, IrradianceBelowABallAboveWaves) {
    Case c{wavy_pool(1), {{0, Event::transmission, 1}}};
    c.state.camera.target = {0, -1, 0};
    c.state.camera.field_of_view = 40 * scene::kDegree;
    c.state.objects.push_back(glass_ball({-0.5, 0.6, 0}, 0.3));
    c.state.caustics.reference = {0.05, 5};
    std::vector<Setting> settings = {{16, 0, 1}, {16, 2, 1}, {16, 4, 1}};
    if (DAPPLE_LONG) settings = {{64, 0, 1}, {128, 0, 1}, {256, 0, 1}};
    const std::vector<Row> r = rows("ball above waves", c, settings, false);
    if (DAPPLE_LONG) {
        EXPECT_LT(r[2].l1, 1.3 * r[2].noise);
        EXPECT_LT(std::abs(r[2].bias), 0.005);
        return;
    }
    // Cells of the first row know little of the waves that a focus falls on.
    EXPECT_LT(r[1].l1, 0.5 * r[0].l1);
    EXPECT_LT(std::abs(r[2].bias), std::abs(r[1].bias));
    // As much as the ball alone leaves, and the reference's noise.
    EXPECT_LT(r[2].l1, 0.02 + r[2].noise);
}

}  // namespace
}  // namespace dapple
