#pragma once
#include <functional>

#include "scene/area_light.h"

/// Area lights that face down, and what is summed over all their points.
namespace dapple::test {

inline scene::Light quad_panel(glm::dvec3 position, glm::dvec2 size, int samples) {
    scene::Light light;
    light.name = "panel";
    light.type = scene::LightType::quad;
    light.position = position;
    light.size = size;
    light.radiance = {3, 2, 1};
    light.samples = samples;
    return light;
}

inline scene::Light disc_panel(glm::dvec3 position, double radius, int samples) {
    scene::Light light = quad_panel(position, {1, 1}, samples);
    light.type = scene::LightType::disc;
    light.radius = radius;
    return light;
}

/// Integral over the area of an emitter that faces straight down [m^2], written apart from the program's: x
/// to the right and z down in a picture seen from above.
inline double over_panel(const scene::Light& panel, const std::function<double(glm::dvec3)>& value,
                         int steps = 48) {
    double sum = 0;
    const bool quad = panel.type == scene::LightType::quad;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double a = (i + 0.5) / steps, b = (j + 0.5) / steps;
            const double r = panel.radius * a, angle = 2 * std::numbers::pi * b;
            const glm::dvec3 off = quad ? glm::dvec3((a - 0.5) * panel.size.x, 0, (b - 0.5) * panel.size.y)
                                        : glm::dvec3(r * std::cos(angle), 0, r * std::sin(angle));
            const double area = quad ? panel.size.x * panel.size.y : 2 * std::numbers::pi * r * panel.radius;
            sum += value(panel.position + off) * area / (steps * steps);
        }
    return sum;
}

}  // namespace dapple::test
