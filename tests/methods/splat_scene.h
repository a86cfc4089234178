#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "gpu/validated_device.h"
#include "light/water_grids.h"
#include "methods/photon_splatting/photon_splatting.h"
#include "view/camera.h"

/// Pools with level receivers, and what photons make of them.
namespace dapple::test {

inline constexpr double kIndex = 1.333;

/// A floor at -depth (or a ceiling), larger than all light.
inline scene::Object level(double height, double size = 60) {
    scene::Object plane;
    plane.name = height < 0 ? "floor" : "ceiling";
    plane.size = {size, 1, size};
    plane.transform.position = {0, height, 0};
    if (height > 0) plane.transform.rotation = {glm::pi<double>(), 0, 0};
    return plane;
}

/// Receivers on the level plane at `height` for a camera that looks at it from the water's side: what
/// trace_layer would find, by hand, so that these tests rest on the light side alone.
inline view::ReceiverLayer receivers_on_level(const scene::FrameScene& scene, double height, int sample = 0) {
    const scene::FrameState& state = scene.state;
    const view::Camera camera(state.camera, state.clip.width, state.clip.height);
    view::ReceiverLayer layer;
    layer.width = state.clip.width;
    layer.height = state.clip.height;
    layer.sample = sample;
    const std::uint32_t flags = view::kReceiver | (height < 0 ? view::kInWater : 0u);
    const auto seen_at = [&](glm::dvec2 pixel) {
        glm::dvec3 origin, direction;
        camera.ray(pixel, origin, direction);
        return origin + direction * ((height - origin.y) / direction.y);
    };
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x) {
            const glm::dvec2 pixel =
                glm::dvec2(x, y) + view::Camera::sample_offset(sample, state.clip.samples);
            const glm::dvec2 right(0.5, 0), down(0, 0.5);
            layer.flags.push_back(flags);
            layer.position.emplace_back(seen_at(pixel) - scene.origin);
            layer.footprint_u.emplace_back(seen_at(pixel + right) - seen_at(pixel - right));
            layer.footprint_v.emplace_back(seen_at(pixel + down) - seen_at(pixel - down));
            layer.shading_normal.emplace_back(0, height < 0 ? 1 : -1, 0);
        }
    layer.geometric_normal = layer.shading_normal;
    return layer;
}

inline void look_down(scene::FrameScene& scene, int pixels, double view) {
    scene.state.clip.width = scene.state.clip.height = pixels;
    scene.state.clip.samples = 1;
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.position = {0, -0.1, 0};
    scene.state.camera.target = {0, -1, 0};
    scene.state.camera.up = {0, 0, -1};
    scene.state.camera.view_height = view;
}

inline std::vector<methods::LayerResult> splat(
    const scene::FrameScene& scene, std::vector<light::Chain> chains,
    std::span<const view::ReceiverLayer> layers, FrameStats& stats,
    methods::RasterBackend backend = methods::RasterBackend::automatic) {
    const rays::RayScene rays(scene);
    methods::FrameContext context{scene, rays, validated_device(), stats, std::move(chains)};
    methods::PhotonSplatting method(backend);
    method.begin(context);
    std::vector<methods::LayerResult> results(layers.size());
    method.irradiance(context, layers, results);
    return results;
}

inline methods::LayerResult splat_level(const scene::FrameScene& scene, double height,
                                        light::Event event = light::Event::transmission) {
    FrameStats stats;
    const std::vector<view::ReceiverLayer> layers = {receivers_on_level(scene, height)};
    return splat(scene, {{0, event}}, layers, stats)[0];
}

inline double flat_transmittance(double i) {
    if (i == 0) return 1 - std::pow((kIndex - 1) / (kIndex + 1), 2);
    const double t = std::asin(std::sin(i) / kIndex);
    const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
    return 1 - 0.5 * (s * s + p * p);
}

/// Flat water of 6 m over a floor 1.5 m down.
inline scene::FrameScene flat_pool(double zenith, int resolution) {
    scene::FrameScene scene = water_scene({6, 6});
    scene.state.lights = {sun(zenith, 33)};
    scene.state.objects = {level(-1.5)};
    scene.state.caustics.map.map_resolution = resolution;
    scene.origin = {1, -2, 3};
    add_water(scene, {}, 8, 8);
    return scene;
}

inline glm::dvec3 flat_floor(const scene::FrameScene& scene, double zenith) {
    const double i = glm::radians(zenith), t = std::asin(std::sin(i) / kIndex);
    return scene.state.lights[0].irradiance * std::cos(i) * flat_transmittance(i) *
           glm::exp(-scene.state.water->extinction() * (1.5 / std::cos(t)));
}

}  // namespace dapple::test
