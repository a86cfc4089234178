#pragma once
#include <numeric>

#include "gpu/validated_device.h"
#include "light/water_grids.h"
#include "methods/caustic_mesh/caustic_mesh.h"
#include "view/camera.h"

/// Frames of the caustic mesh on planes, with receivers made by hand: these tests rest on the light side
/// alone.
namespace dapple::test {

constexpr double kMeshIndex = 1.333;

/// A plane; `normal` as its receivers see it.
struct Plane {
    glm::dvec3 point{0}, normal{0, 1, 0};
};

/// Receivers where the camera's rays meet the plane.
inline view::ReceiverLayer receivers_on(const scene::FrameScene& scene, const Plane& plane, bool in_water,
                                        int sample = 0) {
    const scene::FrameState& state = scene.state;
    const view::Camera camera(state.camera, state.clip.width, state.clip.height);
    view::ReceiverLayer layer;
    layer.width = state.clip.width;
    layer.height = state.clip.height;
    layer.sample = sample;
    for (int y = 0; y < layer.height; ++y)
        for (int x = 0; x < layer.width; ++x) {
            glm::dvec3 origin, direction;
            camera.ray(glm::dvec2(x, y) + view::Camera::sample_offset(sample, state.clip.samples), origin,
                       direction);
            const double distance =
                glm::dot(plane.normal, plane.point - origin) / glm::dot(plane.normal, direction);
            layer.flags.push_back(view::kReceiver | (in_water ? view::kInWater : 0u));
            layer.position.emplace_back(origin + distance * direction - scene.origin);
            layer.shading_normal.emplace_back(plane.normal);
        }
    layer.geometric_normal = layer.shading_normal;
    return layer;
}

/// A plane of the scene, seen from the side of its normal (0, 1, 0) turned by `rotation`.
inline scene::Object plane_object(glm::dvec3 position, double size, glm::dvec3 rotation = glm::dvec3(0)) {
    scene::Object plane;
    plane.size = {size, 1, size};
    plane.transform.position = position;
    plane.transform.rotation = rotation;
    return plane;
}

/// An orthographic view from `position` towards `target`.
inline void look(scene::FrameScene& scene, glm::ivec2 pixels, double height, glm::dvec3 position,
                 glm::dvec3 target, glm::dvec3 up) {
    scene.state.clip.width = pixels.x;
    scene.state.clip.height = pixels.y;
    scene.state.clip.samples = 1;
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.position = position;
    scene.state.camera.target = target;
    scene.state.camera.up = up;
    scene.state.camera.view_height = height;
}

inline std::vector<methods::LayerResult> draw_mesh(
    const scene::FrameScene& scene, light::Event event, std::span<const view::ReceiverLayer> layers,
    FrameStats& stats, methods::RasterBackend backend = methods::RasterBackend::automatic) {
    const rays::RayScene rays(scene);
    methods::FrameContext context{scene, rays, validated_device(), stats, {{0, event}}};
    methods::CausticMesh method(backend);
    method.begin(context);
    std::vector<methods::LayerResult> results(layers.size());
    method.irradiance(context, layers, results);
    return results;
}

inline methods::LayerResult draw_mesh(const scene::FrameScene& scene, const view::ReceiverLayer& layer,
                                      light::Event event = light::Event::transmission) {
    FrameStats stats;
    return draw_mesh(scene, event, {&layer, 1}, stats)[0];
}

inline double transmittance(double i) {
    if (i == 0) return 1 - std::pow((kMeshIndex - 1) / (kMeshIndex + 1), 2);
    const double t = std::asin(std::sin(i) / kMeshIndex);
    const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
    return 1 - 0.5 * (s * s + p * p);
}

}  // namespace dapple::test
