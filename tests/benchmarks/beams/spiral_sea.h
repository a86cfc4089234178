#pragma once
#include <cmath>
#include <glm/glm.hpp>

#include "scene/frame_state.h"

namespace dapple::bench {

/// 24 waves of lengths from `shortest` to `longest`, m, in equal ratios, amplitude `steepness` of the length,
/// in all directions.
inline void add_waves(scene::Water& water, double shortest, double longest, double steepness) {
    for (int i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = shortest * std::pow(longest / shortest, i / 23.0);
        wave.heading = 2.399963229728653 * i;
        wave.amplitude = steepness * wave.length;
        wave.phase = 1.7 * i * i;
        const double k = 2 * 3.141592653589793 / wave.length;
        wave.wave_vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        water.surface.waves.waves.push_back(wave);
    }
}

}  // namespace dapple::bench
