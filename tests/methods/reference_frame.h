#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <vector>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "methods/reference/reference.h"
#include "ocean/water_surface.h"
#include "view/camera_paths.h"

/// What the tests of the reference share: a frame without the rest of the program, and its agreement with
/// closed forms.
namespace dapple::test {

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
        if (!state.water) return;
        scene.water =
            std::make_shared<const scene::WaterMesh>(ocean::WaterSurface(*state.water).mesh(state.time));
    }
    LayerResult render() {
        rays.emplace(scene);
        view::LayerCounts counts;
        const view::ReceiverLayer layer = view::trace_layer(scene, *rays, {}, counts);
        methods::FrameContext context{scene, *rays, validated_device(), stats, chains, checkpoint};
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

inline Agreement agreement(const LayerResult& result, const std::vector<double>& expected, int channel = 0) {
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
inline constexpr double kWorstT = 7.6;
/// Mean square of such t, and its standard deviation.
inline constexpr double kMeanSquareT = 15.0 / 13, kSpreadOfSquareT = 1.84;

inline void expect_agreement(const Agreement& a) {
    EXPECT_LT(a.worst, kWorstT);
    EXPECT_LT(std::abs(a.mean), 3);
    EXPECT_NEAR(a.mean_square, kMeanSquareT, 5 * kSpreadOfSquareT / std::sqrt(a.pixels));
}

inline scene::FrameState small_pool(double patch, double depth, double view, int pixels) {
    scene::FrameState state = pool_over_floor(patch, depth, view, pixels);
    state.caustics.method = "reference";
    state.caustics.reference = {0.02, 100};
    return state;
}

/// Standard error so large that the first round, a million rays a light, is the answer.
inline constexpr scene::ReferenceParameters kOneRound{1e9, 1};

/// Mean of `value` over each pixel of a square picture of `view` m, by 4 x 4 points; x to the right and z
/// down from the middle.
inline std::vector<double> pixel_means(double view, int pixels,
                                       const std::function<double(double, double)>& value) {
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
inline Refraction refract(double angle, double index_from, double index_to) {
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
inline double across_flat_water(double a, double b, double index_from, double index_to, double r,
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

/// L1 of E against that of `truth`, over its mean; red.
inline double relative_l1(const LayerResult& found, const LayerResult& truth) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < truth.irradiance.size(); ++i) {
        difference += std::abs(static_cast<double>(found.irradiance[i].x - truth.irradiance[i].x));
        sum += static_cast<double>(truth.irradiance[i].x);
    }
    return difference / sum;
}

}  // namespace dapple::test
