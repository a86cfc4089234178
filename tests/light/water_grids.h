#pragma once
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <memory>
#include <vector>

#include "scene/frame_scene.h"

/// Water grids built by hand, so that the light side is tested without the ocean.
namespace dapple::test {

struct Sinusoid {
    double amplitude;  // m
    glm::dvec2 wave;   // rad/m
    double phase;
};

/// Height and slope of a sum of sinusoids at (x, z).
inline glm::dvec3 height_and_slope(const std::vector<Sinusoid>& sea, glm::dvec2 at) {
    glm::dvec3 result(0);
    for (const Sinusoid& s : sea) {
        const double angle = glm::dot(s.wave, at) + s.phase;
        result += s.amplitude *
                  glm::dvec3(std::cos(angle), -s.wave.x * std::sin(angle), -s.wave.y * std::sin(angle));
    }
    return result;
}

/// 24 waves of 0.25 to 3 m in all directions; rms slope about 0.07 times `steepness` / 0.0032.
inline std::vector<Sinusoid> gentle_sea(double steepness = 0.0032) {
    std::vector<Sinusoid> sea;
    for (int i = 0; i < 24; ++i) {
        const double length = 0.25 * std::pow(12.0, i / 23.0);
        const double heading = 2.399963 * i;  // golden angle
        const double k = glm::two_pi<double>() / length;
        sea.push_back({steepness * length, {k * std::cos(heading), k * std::sin(heading)}, 1.7 * i});
    }
    return sea;
}

/// A grid of cells_x by cells_z over the extent of the scene's water, cut into triangles as the ocean's are.
inline void add_water(scene::FrameScene& scene, const std::vector<Sinusoid>& sea, int cells_x, int cells_z) {
    const scene::Extent& extent = scene.state.water->extent;
    auto water = std::make_shared<scene::WaterMesh>();
    water->columns = cells_x + 1;
    water->rows = cells_z + 1;
    for (const Sinusoid& s : sea) water->height_bound += s.amplitude;
    for (int row = 0; row <= cells_z; ++row)
        for (int column = 0; column <= cells_x; ++column) {
            const glm::dvec2 at =
                extent.center +
                extent.size * (glm::dvec2(double(column) / cells_x, double(row) / cells_z) - 0.5);
            const glm::dvec3 h = height_and_slope(sea, at);
            water->mesh.positions.emplace_back(at.x, h.x, at.y);
            water->mesh.normals.push_back(glm::normalize(glm::dvec3(-h.y, 1, -h.z)));
        }
    for (int row = 0; row < cells_z; ++row)
        for (int column = 0; column < cells_x; ++column) {
            const auto a = static_cast<std::uint32_t>(row * water->columns + column);
            const auto below = a + static_cast<std::uint32_t>(water->columns);
            water->mesh.triangles.emplace_back(a, below, a + 1);
            water->mesh.triangles.emplace_back(a + 1, below, below + 1);
        }
    scene.water = water;
}

inline scene::FrameScene water_scene(glm::dvec2 size, glm::dvec2 center = {0, 0}) {
    scene::FrameScene scene;
    scene.state.water.emplace();
    scene.state.water->extent.size = size;
    scene.state.water->extent.center = center;
    return scene;
}

inline scene::Light sun(double zenith_degrees, double azimuth_degrees = 20) {
    const double zenith = glm::radians(zenith_degrees), azimuth = glm::radians(azimuth_degrees);
    scene::Light light;
    light.name = "sun";
    light.direction = {-std::sin(zenith) * std::cos(azimuth), -std::cos(zenith),
                       -std::sin(zenith) * std::sin(azimuth)};
    light.angular_diameter = 0;
    return light;
}

}  // namespace dapple::test
