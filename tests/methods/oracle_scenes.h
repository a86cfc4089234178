#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/hash.h"
#include "scene/frame_state.h"

/// Waters and lights of the oracle's tests.
namespace dapple::test {

/// A sun that stands at these angles; its light travels along -x for azimuth 0.
inline scene::Light sun_at(double elevation_degrees, double azimuth_degrees = 0) {
    const double e = elevation_degrees * scene::kDegree, a = azimuth_degrees * scene::kDegree;
    scene::Light sun;
    sun.direction = {-std::cos(e) * std::cos(a), -std::sin(e), -std::cos(e) * std::sin(a)};
    return sun;
}

inline scene::Light lamp_at(glm::dvec3 position) {
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = position;
    return lamp;
}

/// 24 sinusoids of 0.15 to 1.2 m, log-uniform in length and uniform in heading and phase, rms slope 0.070.
inline scene::Water sea_of_24_waves(std::uint64_t seed) {
    scene::Water water;
    for (std::uint32_t w = 0; w < 24; ++w) {
        const double length = 0.15 * std::pow(8.0, (w + hash_uniform(seed, 0, w, 0)) / 24);
        scene::Wave wave;
        wave.length = length;
        wave.heading = 2 * std::numbers::pi * hash_uniform(seed, 0, w, 1);
        wave.amplitude = 0.0032 * length;
        wave.phase = 2 * std::numbers::pi * hash_uniform(seed, 0, w, 2);
        water.surface.waves.waves.push_back(wave);
    }
    water.extent.size = {40, 40};
    return water;
}

/// h = amplitude cos(2 pi x / length).
inline scene::Water one_sinusoid(double length, double amplitude) {
    scene::Water water;
    scene::Wave wave;
    wave.length = length;
    wave.amplitude = amplitude;
    water.surface.waves.waves = {wave};
    water.extent.size = {40, 2};
    return water;
}

/// Uniform in [low, high).
inline double random_between(double low, double high, std::uint64_t index, std::uint32_t dimension) {
    return low + (high - low) * hash_uniform(7, 0, index, dimension);
}

}  // namespace dapple::test
