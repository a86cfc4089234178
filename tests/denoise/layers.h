#pragma once
#include <cstdint>
#include <vector>

#include "base/hash.h"
#include "view/receiver_layer.h"

namespace dapple::test {

/// A level plane, a pixel every `spacing` m in x and z, all of it one object in the water.
inline view::ReceiverLayer plane_layer(int width, int height, float spacing) {
    view::ReceiverLayer layer;
    layer.width = width;
    layer.height = height;
    const std::size_t pixels = layer.pixels();
    layer.flags.assign(pixels, view::kReceiver | view::kInWater);
    layer.object.assign(pixels, 0);
    layer.geometric_normal.assign(pixels, glm::vec3(0, 1, 0));
    layer.shading_normal = layer.geometric_normal;
    layer.footprint_u.assign(pixels, glm::vec3(spacing, 0, 0));
    layer.footprint_v.assign(pixels, glm::vec3(0, 0, spacing));
    layer.depth.assign(pixels, 2.0f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            layer.position.emplace_back(spacing * static_cast<float>(x), -2.0f,
                                        spacing * static_cast<float>(y));
    return layer;
}

/// A number in [0, 1) for each pixel and purpose, the same in all runs.
inline float random_number(std::size_t pixel, std::uint32_t purpose) {
    return static_cast<float>(hash_uniform(7, 1, static_cast<std::uint32_t>(pixel), purpose));
}

/// One pixel in `every` is lit, as by photons that are too few.
inline std::vector<glm::vec3> sparse_splats(const view::ReceiverLayer& layer, int every, float strength) {
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(0));
    for (std::size_t i = 0; i < irradiance.size(); ++i)
        if (random_number(i, 3) * static_cast<float>(every) < 1) irradiance[i] = glm::vec3(strength);
    return irradiance;
}

}  // namespace dapple::test
