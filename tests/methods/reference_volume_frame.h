#pragma once
#include "methods/reference_frame.h"
#include "scene/medium.h"
#include "view/camera.h"

/// What the tests of the reference's S share.
namespace dapple::test {

/// A frame whose light in media is asked for.
struct VolumeFrame : Frame {
    using Frame::Frame;
    view::SegmentLayer segments;
    std::vector<glm::vec3> radiance;  ///< S a segment

    /// What the pixels receive, and its variance, as if it were E.
    LayerResult scatter(int branch = 0) {
        rays.emplace(scene);
        view::LayerCounts counts;
        view::trace_layer(scene, *rays, {0, branch}, counts, &segments);
        methods::FrameContext context{scene, *rays, validated_device(), stats, chains, checkpoint};
        Reference method(options);
        method.begin(context);
        radiance.assign(segments.segments(), glm::vec3(0));
        method.in_scatter(context, segments, radiance);
        LayerResult result;
        result.irradiance.assign(segments.first.size() - 1, glm::vec3(0));
        for (std::size_t pixel = 0; pixel + 1 < segments.first.size(); ++pixel)
            for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i)
                result.irradiance[pixel] += segments.throughput[i] * radiance[i];
        result.data = method.in_scatter_data();
        return result;
    }
};

/// Water over a floor and before a wall, seen by an eye in it.
inline scene::FrameState water_with_eye(glm::dvec3 eye, glm::dvec3 towards, int width, int height) {
    scene::FrameState state;
    state.clip.width = width;
    state.clip.height = height;
    state.clip.samples = 1;
    state.camera.position = eye;
    state.camera.target = eye + towards;
    state.camera.field_of_view = 50 * scene::kDegree;
    if (std::abs(normalize(towards).y) > 0.99) state.camera.up = {0, 0, -1};
    state.water.emplace();
    state.water->extent.size = {8, 8};
    state.water->absorption = {0.3, 0.1, 0.05};
    state.water->scattering = {0.05, 0.1, 0.2};
    state.water->phase.type = scene::PhaseType::henyey_greenstein;
    state.water->phase.anisotropy = 0.6;
    state.objects.push_back(level_plane("floor", -2, 20));
    scene::Object wall = level_plane("wall", 0, 20);
    wall.transform.position = {0, 0, -2};
    wall.transform.rotation.x = 90 * scene::kDegree;
    state.objects.push_back(wall);
    state.lights = {sun_from_zenith(35)};
    state.caustics.method = "reference";
    state.caustics.reference = {0.03, 100};
    return state;
}

inline double henyey_greenstein(double g, double cosine) {
    return (1 - g * g) / (4 * glm::pi<double>() * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// Radiance that arrives at `depth` m below flat water from the direction opposite to `way` (unit, away from
/// the eye), whose segment ends after `length` m: L = sigma_s p E / cos_t exp(-sigma_t y0 / cos_t)
/// (1 - exp(-a S)) / a, a = sigma_t (1 + w_y / cos_t), E on a level plane, without the phase function.
inline double flat_water_scatter(const scene::FrameState& state, double zenith, double depth,
                                 const glm::dvec3& way, double length, int channel, double anisotropy) {
    const double n = state.water->refractive_index;
    const FlatFloor below = flat_floor(zenith, 1, n);
    const double cos_t = 1 / below.way;
    const double sigma_s = state.water->scattering[channel];
    const double sigma_t = sigma_s + state.water->absorption[channel];
    const glm::dvec3 light(std::sin(glm::radians(zenith)) / n, -cos_t, 0);
    const double a = sigma_t * (1 - way.y / cos_t);
    const double along = std::abs(a * length) < 1e-9 ? length : -std::expm1(-a * length) / a;
    return state.lights[0].irradiance[channel] * sigma_s * henyey_greenstein(anisotropy, -dot(light, way)) *
           below.irradiance / cos_t * std::exp(-sigma_t * depth / cos_t) * along;
}

/// Means over pixels of what camera rays (origin, direction) receive, by 4 x 4 rays each.
inline std::vector<double> over_pixels(
    const scene::FrameState& state,
    const std::function<double(const glm::dvec3&, const glm::dvec3&)>& radiance) {
    const view::Camera camera(state.camera, state.clip.width, state.clip.height);
    std::vector<double> means;
    constexpr int points = 4;
    for (int y = 0; y < state.clip.height; ++y) {
        for (int x = 0; x < state.clip.width; ++x) {
            double sum = 0;
            for (int k = 0; k < points * points; ++k) {
                glm::dvec3 origin, direction;
                const int column = k % points, row = k / points;
                camera.ray({x + (column + 0.5) / points, y + (row + 0.5) / points}, origin, direction);
                sum += radiance(origin, direction);
            }
            means.push_back(sum / (points * points));
        }
    }
    return means;
}

/// Errors of neighbouring pixels go together, since a way of light crosses many: so the mean over the picture
/// is only known to be better than a pixel, and the spread of t is wider than that of independent pixels.
inline void expect_scatter(const LayerResult& result, const std::vector<double>& expected, double error,
                           int channel) {
    const Agreement a = agreement(result, expected, channel);
    EXPECT_LT(a.worst, kWorstT);
    EXPECT_LT(std::abs(a.relative_mean), 3 * error);
    EXPECT_LT(a.mean_square, 3 * kMeanSquareT);
    EXPECT_GT(a.mean_square, kMeanSquareT / 3);
}

/// A ray in the space of a unit cube about its middle.
inline scene::Medium box_of_smoke(glm::dvec3 position, glm::dvec3 size) {
    scene::Medium box;
    box.name = "smoke";
    box.type = scene::MediumType::box;
    box.density = 2;
    box.extinction = {0.3, 0.2, 0.1};
    box.albedo = {0.9, 0.6, 0.3};
    box.transform.position = position;
    box.transform.rotation = {0.2, 0.5, -0.3};
    box.size = size;
    return box;
}

/// Midpoint rule for the integral of `value` from 0 to `length`.
inline double integral(double length, int steps, const std::function<double(double)>& value) {
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += value(length * (i + 0.5) / steps);
    return sum * length / steps;
}

}  // namespace dapple::test
