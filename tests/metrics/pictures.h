#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>

#include "base/hash.h"
#include "metrics/picture.h"

/// Small pictures whose figures can be worked out.
namespace dapple::metrics::testing_pictures {

/// Pixels by position; luminance is the mean of the channels, which serves where only its shape matters.
inline Picture picture_by(int width, int height, const std::function<glm::vec3(int x, int y)>& colour) {
    Picture picture;
    picture.width = width;
    picture.height = height;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::vec3 value = colour(x, y);
            for (int c = 0; c < 3; ++c) picture.rgb[static_cast<std::size_t>(c)].push_back(value[c]);
            picture.luminance.push_back((value.r + value.g + value.b) / 3);
        }
    }
    return picture;
}

inline Picture constant(int width, int height, glm::vec3 colour) {
    return picture_by(width, height, [colour](int, int) { return colour; });
}

/// Waves of some lengths with noise on them, rounded to 8 bits; `seed` draws the noise.
inline Picture eight_bit_scene(int width, int height, std::uint64_t seed, float noise) {
    return picture_by(width, height, [=](int x, int y) {
        glm::vec3 value;
        for (int c = 0; c < 3; ++c) {
            const double wave = 0.5 + 0.3 * std::sin(0.11 * x + 0.7 * c) * std::cos(0.07 * y * (c + 1));
            const double draw = hash_uniform(seed, 0, static_cast<std::uint64_t>(y * width + x),
                                             static_cast<std::uint32_t>(c));
            const double held = std::fmin(1, std::fmax(0, wave + noise * (draw - 0.5)));
            value[c] = static_cast<float>(std::round(held * 255) / 255);
        }
        return value;
    });
}

/// Leaves out the pixel as picture_of does with one that is not finite.
inline void exclude(Picture& picture, std::uint32_t pixel) {
    for (std::vector<float>& plane : picture.rgb) plane[pixel] = 0;
    picture.luminance[pixel] = 0;
    picture.excluded.push_back(pixel);
}

}  // namespace dapple::metrics::testing_pictures
