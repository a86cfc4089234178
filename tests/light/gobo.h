#pragma once
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "image/texture.h"
#include "scene/frame_scene.h"

/// Spots with pictures for tests.
namespace dapple::test {

/// Values at texel middles; u to the right, v up, both in [0, 1].
inline std::shared_ptr<const image::Texture> picture(int width, int height,
                                                     const std::function<glm::vec3(float, float)>& value) {
    std::vector<float> rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::vec3 at = value((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                       1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
            rgb.insert(rgb.end(), {at.r, at.g, at.b});
        }
    return std::make_shared<const image::Texture>(width, height, std::move(rgb));
}

/// `cells` by `cells` fields of 1 and 0.1.
inline std::shared_ptr<const image::Texture> checkers(int size, int cells) {
    return picture(size, size, [=](float u, float v) {
        const auto field = [&](float x) { return static_cast<int>(x * static_cast<float>(cells)); };
        return glm::vec3((field(u) + field(v)) % 2 == 0 ? 1.0f : 0.1f);
    });
}

inline scene::Light spot(const glm::dvec3& position, const glm::dvec3& target, double cone_degrees = 30) {
    scene::Light light;
    light.name = "spot";
    light.type = scene::LightType::spot;
    light.position = position;
    light.direction = glm::normalize(target - position);
    light.cone_angle = cone_degrees * scene::kDegree;
    light.falloff_angle = 2 * scene::kDegree;
    light.intensity = {10, 20, 30};
    return light;
}

}  // namespace dapple::test
