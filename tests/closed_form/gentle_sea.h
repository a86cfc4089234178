#pragma once
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "scene/frame_scene.h"

namespace dapple::test {

/// 24 waves of 0.25 to 2 m, rms slope about 0.03: gentle enough that no facet shadows another.
inline scene::Waves gentle_waves() {
    scene::Waves sea;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = 0.25 * std::pow(8.0, i / 23.0);
        wave.heading = 2 * glm::pi<double>() * uniform(random);
        wave.phase = 2 * glm::pi<double>() * uniform(random);
        wave.amplitude = 0.0014 * wave.length;
        sea.waves.push_back(wave);
    }
    return sea;
}

/// Flux through the surface for a sun of unit irradiance, in double over the mesh: per triangle the area that
/// faces the light times the share that the light's angle to the vertex normals lets through (mean of the
/// corners).
struct MeshFlux {
    double transmitted = 0;
    double reflected = 0;
};

inline MeshFlux flux_through(const scene::WaterMesh& water, glm::dvec3 direction, double index) {
    MeshFlux sum;
    const auto& [positions, normals, uv, triangles] = water.mesh;
    for (const glm::uvec3& triangle : triangles) {
        const glm::dvec3 a = positions[triangle.x], b = positions[triangle.y], c = positions[triangle.z];
        const double facing = -0.5 * glm::dot(glm::cross(b - a, c - a), direction);
        double transmittance = 0;
        for (int corner = 0; corner < 3; ++corner) {
            const double cos_i = -glm::dot(direction, normals[triangle[corner]]);
            const double i = std::acos(cos_i), t = std::asin(std::sin(i) / index);
            const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
            transmittance += (1 - 0.5 * (s * s + p * p)) / 3;
        }
        sum.transmitted += facing * transmittance;
        sum.reflected += facing * (1 - transmittance);
    }
    return sum;
}

}  // namespace dapple::test
