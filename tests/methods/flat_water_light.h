#pragma once
#include "methods/mesh_frame.h"

/// The caustic mesh below flat water, and its closed form.
namespace dapple::test {

inline const Plane kPoolFloor{{0, -1.5, 0}};

/// Flat water of 6 m over a floor 1.5 m down, looked at from above.
inline scene::FrameScene flat_pool(double zenith, int resolution, int pixels) {
    scene::FrameScene scene = water_scene({6, 6});
    scene.state.lights = {sun(zenith, 33)};
    scene.state.objects = {plane_object({0, -1.5, 0}, 60)};
    scene.state.caustics.map.map_resolution = resolution;
    scene.origin = {1, -2, 3};
    add_water(scene, {}, 8, 8);
    look(scene, glm::ivec2(pixels), 2, {0, -0.1, 0}, {0, -1, 0}, {0, 0, -1});
    return scene;
}

/// Where light of the scene's sun is refracted to by flat water.
inline glm::dvec3 refracted(const scene::FrameScene& scene) {
    const glm::dvec3 way = scene.state.lights[0].direction;
    const glm::dvec3 level = glm::dvec3(way.x, 0, way.z) / kMeshIndex;
    return level - glm::dvec3(0, std::sqrt(1 - glm::dot(level, level)), 0);
}

/// E on a plane under flat water, at a point in the world.
inline glm::dvec3 under_flat_water(const scene::FrameScene& scene, const Plane& plane, glm::dvec3 point) {
    const scene::Light& sun = scene.state.lights[0];
    const double cosine = -sun.direction.y;
    const glm::dvec3 way = refracted(scene);
    return sun.irradiance * cosine * transmittance(std::acos(cosine)) *
           (glm::dot(plane.normal, way) / way.y) *
           glm::exp(scene.state.water->extinction() * (point.y / -way.y));
}

}  // namespace dapple::test
