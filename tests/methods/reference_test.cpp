// The brute-force reference against closed forms, and the honesty of its standard errors.
#include "methods/reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "ocean/water_surface.h"
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
    a.mean = error / std::sqrt(variance);
    a.relative_mean = error / sum;
    printf("worst |t| %.2f, mean %.2f standard errors (%.1e), mean t^2 %.3f\n", a.worst, a.mean,
           a.relative_mean, a.mean_square);
    return a;
}

/// t of a pixel's mean over 16 passes has 15 degrees of freedom: |t| exceeds this once in a million.
constexpr double kWorstT = 7.6;
/// Mean square of such t, and its standard deviation over 1024 pixels.
constexpr double kMeanSquareT = 15.0 / 13, kSpreadOfMeanSquare = 1.84 / 32;

void expect_agreement(const Agreement& a) {
    EXPECT_LT(a.worst, kWorstT);
    EXPECT_LT(std::abs(a.mean), 3);
    EXPECT_NEAR(a.mean_square, kMeanSquareT, 5 * kSpreadOfMeanSquare);
}

scene::FrameState small_pool(double patch, double depth, double view, int pixels) {
    scene::FrameState state = test::pool_over_floor(patch, depth, view, pixels);
    state.caustics.method = "reference";
    state.caustics.reference = {0.02, 100};
    return state;
}

TEST(Reference, FlatWaterUnderASun) {
    scene::FrameState state = small_pool(3, 1, 1, 32);
    state.lights = {test::sun_from_zenith(35)};
    Frame frame(state);
    const LayerResult result = frame.render();
    const test::FlatFloor exact = test::flat_floor(35, 1, state.water->refractive_index);
    for (int channel = 0; channel < 3; ++channel) {
        const double e = state.lights[0].irradiance[channel] * exact.irradiance *
                         std::exp(-state.water->absorption[channel] * exact.way);
        expect_agreement(agreement(result, std::vector<double>(1024, e), channel));
    }
    printf("%.0f rays, standard error %.4f\n", frame.stats.counted("reference rays"),
           frame.stats.counted("reference standard error"));
    EXPECT_LE(frame.stats.counted("reference standard error"), 0.02);
    for (const PassTime& pass : frame.stats.passes()) printf("%s %.2f s\n", pass.name.c_str(), pass.cpu_s);
}

}  // namespace
}  // namespace dapple
