#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "methods/adaptive_beams/make_beams.h"
#include "ocean/water_surface.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

/// Frames for the light side of adaptive beams.
namespace dapple::test {

inline scene::Light sun_at(double elevation_degrees) {
    scene::Light sun;
    sun.name = "sun";
    const double e = elevation_degrees * scene::kDegree;
    sun.direction = {-std::cos(e), -std::sin(e), 0};
    sun.irradiance = {3, 2.5, 2};
    sun.angular_diameter = 0;
    return sun;
}

inline scene::Light lamp_at(const glm::dvec3& position) {
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = position;
    lamp.intensity = {3, 2.5, 2};
    return lamp;
}

inline scene::Object glass_ball(glm::dvec3 center, double radius, double index) {
    scene::Object ball;
    ball.name = "ball";
    ball.shape = scene::Shape::sphere;
    ball.radius = radius;
    ball.transform.position = center;
    ball.material.glass = true;
    ball.material.refractive_index = index;
    return ball;
}

inline scene::Object floor_at(double y, double size) {
    scene::Object floor;
    floor.name = "floor";
    floor.shape = scene::Shape::plane;
    floor.size = {size, 1, size};
    floor.transform.position = {0, y, 0};
    return floor;
}

/// A pool of 4 m by 4 m; `amplitude` of 12 waves of 0.4 to 1.6 m over their lengths, 0: flat.
inline void add_water(scene::FrameScene& scene, double amplitude, int cells = 64) {
    scene::Water& water = scene.state.water.emplace();
    water.extent.size = {4, 4};
    water.mesh_cells = cells;
    for (int i = 0; i < 12 && amplitude > 0; ++i) {
        scene::Wave wave;
        wave.length = 0.4 * std::pow(4.0, i / 11.0);
        wave.heading = 2.399963229728653 * i;
        wave.amplitude = amplitude * wave.length;
        wave.phase = 1.7 * i * i;
        const double k = 2 * std::numbers::pi / wave.length;
        wave.wave_vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        water.surface.waves.waves.push_back(wave);
    }
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
}

inline double mean(const glm::dvec3& v) {
    return (v.x + v.y + v.z) / 3;
}

}  // namespace dapple::test
