#pragma once
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/caustic_method.h"
#include "ocean/water_surface.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/camera_paths.h"

/// Seas, floors and pictures of the figures of accuracy.
namespace dapple::test {

/// `count` waves, lengths in equal ratios, headings a golden angle apart, phases without order.
inline scene::Water sinusoids(int count, double shortest, double longest, double amplitude_of_length) {
    scene::Water water;
    water.absorption = {0, 0, 0};
    for (int i = 0; i < count; ++i) {
        scene::Wave wave;
        wave.length = shortest * std::pow(longest / shortest, static_cast<double>(i) / (count - 1));
        wave.heading = std::fmod(2.399963229728653 * i, 2 * std::numbers::pi);
        wave.amplitude = amplitude_of_length * wave.length;
        wave.phase = std::fmod(1.7 * i * i, 2 * std::numbers::pi);
        const double k = 2 * std::numbers::pi / wave.length;
        wave.wave_vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        water.surface.waves.waves.push_back(wave);
    }
    return water;
}

/// 24 waves of 0.15 to 1.2 m, rms slope 0.070.
constexpr double kShortestOfSeaA = 0.15;
inline scene::Water sea_a(double size, double cells_per_shortest_wave) {
    scene::Water water = sinusoids(24, kShortestOfSeaA, 1.2, 0.0032);
    water.extent.size = {size, size};
    water.mesh_cells = static_cast<int>(std::lround(size / kShortestOfSeaA * cells_per_shortest_wave));
    return water;
}

/// A sun of irradiance 1 without a disc, its light travelling towards +x.
inline scene::Light point_like_sun(double elevation_degrees) {
    const double elevation = elevation_degrees * scene::kDegree;
    scene::Light sun;
    sun.name = "sun";
    sun.direction = {std::cos(elevation), -std::sin(elevation), 0};
    sun.irradiance = {1, 1, 1};
    sun.angular_diameter = 0;
    return sun;
}

/// m along +x that the sun's light moves below flat water, a m of depth.
inline double shift_of_sun(double elevation_degrees, double refractive_index = 1.333) {
    const double s = std::cos(elevation_degrees * scene::kDegree) / refractive_index;
    return s / std::sqrt(1 - s * s);
}

inline scene::FrameScene scene_of(const scene::FrameState& state) {
    scene::FrameScene scene;
    scene.state = state;
    scene.object_meshes.resize(state.objects.size());
    scene.water =
        std::make_shared<const scene::WaterMesh>(ocean::WaterSurface(*state.water).mesh(state.time));
    return scene;
}

// ---- pictures ---------------------------------------------------------------------------------------------

constexpr double kFloorDepth = 2, kFloorSunElevation = 60;
constexpr double kShortestOfFloor = 0.5;

/// 12 waves of 0.5 to 1 m, rms slope 0.15, over a floor 2 m deep: past the first folds, 1.1 paths a point.
inline scene::FrameState waves_over_floor(double cells_per_shortest_wave, glm::dvec2 water_center,
                                          glm::dvec2 water_size, int pixels) {
    scene::FrameState state;
    state.clip.width = state.clip.height = pixels;
    state.clip.samples = 1;
    state.water = sinusoids(12, kShortestOfFloor, 1, 0.01);
    state.water->extent.center = water_center;
    state.water->extent.size = water_size;
    state.water->mesh_cells =
        static_cast<int>(std::lround(water_size.x / kShortestOfFloor * cells_per_shortest_wave));
    state.lights = {point_like_sun(kFloorSunElevation)};
    return state;
}

inline scene::Object floor_plane(glm::dvec3 position, glm::dvec3 rotation = {0, 0, 0}) {
    scene::Object plane;
    plane.name = "floor";
    plane.size = {20, 1, 20};
    plane.transform.position = position;
    plane.transform.rotation = rotation;
    return plane;
}

/// 1 m of level floor as 128^2 pixels, seen from above by parallel rays from under the waves: pixel (i, j) is
/// the square about x = (i + 0.5) / 128 - 0.5, z = (j + 0.5) / 128 - 0.5.
constexpr int kFloorPixels = 128;
inline scene::FrameState level_floor(double cells_per_shortest_wave) {
    // The water above the floor and that which the sun shines through to it.
    scene::FrameState state = waves_over_floor(cells_per_shortest_wave, {-0.6, 0}, {2.5, 2}, kFloorPixels);
    state.camera.projection = scene::Projection::orthographic;
    state.camera.position = {0, -0.3, 0};
    state.camera.target = {0, -1, 0};
    state.camera.up = {0, 0, -1};
    state.camera.view_height = 1;
    state.objects.push_back(floor_plane({0, -kFloorDepth, 0}));
    return state;
}

constexpr int kPictureSide = 64;

/// About 1 m of it from the air through the waves, in perspective.
inline scene::FrameState seen_from_the_air(double cells_per_shortest_wave) {
    scene::FrameState state = waves_over_floor(
        cells_per_shortest_wave, {-kFloorDepth * shift_of_sun(kFloorSunElevation), 0}, {3, 3}, kPictureSide);
    state.camera.position = {-0.4, 1.6, 0.9};
    state.camera.target = {0, -kFloorDepth, 0};
    state.camera.field_of_view = 14 * scene::kDegree;
    return state;
}
/// A floor that leans by 25 degrees.
inline scene::FrameState sloped_floor(double cells_per_shortest_wave) {
    scene::FrameState state = seen_from_the_air(cells_per_shortest_wave);
    state.objects.push_back(
        floor_plane({0, -kFloorDepth, 0}, {20 * scene::kDegree, 0, -15 * scene::kDegree}));
    return state;
}
/// The top of a sphere of 1 m.
inline scene::FrameState curved_floor(double cells_per_shortest_wave) {
    scene::FrameState state = seen_from_the_air(cells_per_shortest_wave);
    scene::Object sphere;
    sphere.name = "sphere";
    sphere.shape = scene::Shape::sphere;
    sphere.radius = 1;
    sphere.transform.position = {0, -kFloorDepth - 1, 0};
    state.objects.push_back(sphere);
    return state;
}
/// A column from the floor through the water into the air, and its shadow, seen from under the water.
inline scene::FrameState column_in_pool(double cells_per_shortest_wave) {
    scene::FrameState state = waves_over_floor(cells_per_shortest_wave, {-0.5, 0}, {2.5, 2.5}, kPictureSide);
    state.camera.position = {-0.9, -0.6, 1.2};
    state.camera.target = {0.3, -kFloorDepth, 0};
    state.camera.field_of_view = 32 * scene::kDegree;
    state.objects.push_back(floor_plane({0, -kFloorDepth, 0}));
    scene::Object column;
    column.name = "column";
    column.shape = scene::Shape::box;
    column.size = {0.2, 3, 0.2};
    column.transform.position = {-0.1, -0.9, -0.1};
    column.transform.rotation = {0, 20 * scene::kDegree, 0};
    state.objects.push_back(column);
    return state;
}

/// E of a method for the layer of sample 0, branch 0.
struct Picture {
    view::ReceiverLayer layer;
    methods::LayerResult result;
    FrameStats stats;
};
inline Picture take_picture(const scene::FrameState& state, methods::CausticMethod& method,
                            gpu::Device& device) {
    Picture picture;
    const scene::FrameScene scene = scene_of(state);
    const rays::RayScene rays(scene);
    view::LayerCounts counts;
    picture.layer = view::trace_layer(scene, rays, {}, counts);
    methods::FrameContext context{scene, rays, device, picture.stats, {{0, light::Event::transmission}}, {}};
    method.begin(context);
    picture.result.irradiance.assign(picture.layer.pixels(), glm::vec3(0));
    picture.result.covered.assign(picture.layer.pixels(), 0);
    method.irradiance(context, std::span(&picture.layer, 1), std::span(&picture.result, 1));
    return picture;
}

/// Distance of `values` from `truth`.
struct Distance {
    double l1 = 0;    ///< sum of |difference| over the sum of the truth
    double rms = 0;   ///< root mean square over the mean of the truth
    double bias = 0;  ///< difference of the means over the truth's
};
template <class Values, class Truth>
Distance distance(std::size_t count, Values&& values, Truth&& truth) {
    Distance d;
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double difference = static_cast<double>(values(i)) - static_cast<double>(truth(i));
        d.l1 += std::abs(difference);
        d.rms += difference * difference;
        d.bias += difference;
        sum += static_cast<double>(truth(i));
    }
    d.l1 /= sum;
    d.bias /= sum;
    d.rms = std::sqrt(d.rms / static_cast<double>(count)) / (sum / static_cast<double>(count));
    return d;
}

}  // namespace dapple::test
