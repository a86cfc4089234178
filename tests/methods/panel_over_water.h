#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "light/emitters.h"
#include "methods/reference_frame.h"
#include "ocean/lamp_mesh.h"

/// Area lights over flat water, and integrals over the emitter that say what they throw.
namespace dapple::test {

/// A place of an emitter that stands for so much of its area, m^2.
struct EmitterPoint {
    glm::dvec3 position;
    double area;
};

/// An emitter given apart from the program's own frame of it: two vectors across that span the quad, or reach
/// from the middle of the disc to its edge.
struct Panel {
    scene::Light light;
    glm::dvec3 along, across;

    /// Evenly all over it.
    std::vector<EmitterPoint> points(int steps) const {
        const bool disc = light.type == scene::LightType::disc;
        const double area = glm::length(glm::cross(along, across)) * (disc ? glm::pi<double>() : 1);
        std::vector<EmitterPoint> points;
        for (int i = 0; i < steps * steps; ++i) {
            const int row = i / steps;
            const double a = (row + 0.5) / steps, b = (i % steps + 0.5) / steps;
            glm::dvec2 off(a - 0.5, b - 0.5);
            if (disc) {
                const double angle = 2 * glm::pi<double>() * b;
                off = std::sqrt(a) * glm::dvec2(std::cos(angle), std::sin(angle));
            }
            points.push_back({light.position + off.x * along + off.y * across, area / (steps * steps)});
        }
        return points;
    }
    /// Those that the program takes for it.
    std::vector<EmitterPoint> parts() const {
        scene::FrameState state;
        state.lights = {light};
        std::vector<EmitterPoint> points;
        for (const scene::Light& part : scene::with_emitter_parts(state).lights)
            points.push_back({part.position, part.intensity.x / part.radiance.x});
        return points;
    }
};

/// Turned about z from facing straight down towards +x.
inline Panel leaning(scene::Light light, double degrees) {
    const double lean = degrees * scene::kDegree;
    const bool disc = light.type == scene::LightType::disc;
    light.direction = {std::sin(lean), -std::cos(lean), 0};
    // A quad's width lies across the vertical, which is z here, but for one that faces straight down.
    const glm::dvec2 size = disc ? glm::dvec2(light.radius) : light.size;
    const glm::dvec3 slope(std::cos(lean), std::sin(lean), 0), level(0, 0, 1);
    return degrees == 0 ? Panel{light, size.x * slope, size.y * level}
                        : Panel{light, size.x * level, size.y * slope};
}

inline std::vector<Panel> panels_over_water(int samples) {
    const scene::Light quad = quad_panel({0.2, 1.5, 0.1}, {1.2, 0.6}, samples);
    const scene::Light disc = disc_panel({-0.2, 2, 0.3}, 0.5, samples);
    return {leaning(quad, 0), leaning(quad, 35), leaning(disc, -20)};
}

/// The red of E on a level plane `depth` below flat water, of pixels' means: the intensity of a point of the
/// emitter is L dA cos; light leaves it under the angle that across_flat_water finds.
inline std::vector<double> below_flat_water(const scene::Light& emitter,
                                            const std::vector<EmitterPoint>& points,
                                            const scene::Water& water, double depth, double view,
                                            int pixels) {
    // Tables over the distance for the heights that points lie at, linear between: error (step^2) / 8 E''.
    constexpr double kStep = 4e-3;  // m
    struct Entry {
        double irradiance;  // of a lamp of 1 W/sr
        double tangent;     // of the way in the air to the vertical
    };
    const auto table = [&](double height) {
        std::vector<Entry> entries;
        for (int i = 0; i < 1200; ++i) {
            double tangent = 0;
            const double e = across_flat_water(height, depth, 1, water.refractive_index,
                                               std::max(1e-6, i * kStep), [&](double air, double in_water) {
                                                   tangent = std::sqrt(air * air / (height * height) - 1);
                                                   return std::exp(-water.absorption.x * in_water);
                                               });
            entries.push_back({e, tangent});
        }
        return entries;
    };
    std::vector<double> sums(static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels), 0);
    std::vector<Entry> entries;
    double height = -1;
    for (const EmitterPoint& point : points) {
        const glm::dvec3 from = point.position;
        if (std::abs(from.y - height) > 1e-12) entries = table(height = from.y);
        const std::vector<double> of_point = pixel_means(view, pixels, [&](double x, double z) {
            const glm::dvec2 off(x - from.x, z - from.z);
            const double at = glm::length(off) / kStep;
            const auto k = static_cast<std::size_t>(at);
            const double e = glm::mix(entries[k].irradiance, entries[k + 1].irradiance, at - std::floor(at));
            const double t = glm::mix(entries[k].tangent, entries[k + 1].tangent, at - std::floor(at));
            const glm::dvec2 level = t * glm::normalize(off);
            const glm::dvec3 way = glm::normalize(glm::dvec3(level.x, -1, level.y));
            return e * std::max(0.0, glm::dot(way, emitter.direction));
        });
        for (std::size_t k = 0; k < sums.size(); ++k)
            sums[k] += emitter.radiance.x * point.area * of_point[k];
    }
    return sums;
}

/// The red of E on a level plane `height` above flat water, seen from below, by the light that the water
/// mirrors: L F cos cos / d^2 from the emitter's image.
inline std::vector<double> above_flat_water(const scene::Light& emitter,
                                            const std::vector<EmitterPoint>& points,
                                            const scene::Water& water, double height, double view,
                                            int pixels) {
    return pixel_means(view, pixels, [&](double x, double z) {
        double sum = 0;
        for (const auto& [from, area] : points) {
            const glm::dvec3 way = glm::dvec3(x, height + from.y, z) - glm::dvec3(from.x, 0, from.z);
            const double square = glm::dot(way, way), cosine = way.y / std::sqrt(square);
            const glm::dvec3 down = glm::dvec3(way.x, -way.y, way.z) / std::sqrt(square);
            sum += area * std::max(0.0, glm::dot(down, emitter.direction)) * cosine / square *
                   refract(std::acos(cosine), 1, water.refractive_index).reflectance;
        }
        return emitter.radiance.x * sum;
    });
}

/// A pool of 6 m, 1 m deep, its floor seen from above.
inline scene::FrameState pool_under(const scene::Light& light, double view, int pixels) {
    scene::FrameState state = pool_over_floor(6, 1, view, pixels);
    state.lights = {light};
    state.caustics.map.map_resolution = 96;
    state.caustics.adaptive_beams.grid = 128;
    return state;
}

/// A frame as the program builds it: emitters cut into parts, as fine a mesh as lamps call for.
inline Frame panel_frame(const scene::FrameState& state, light::Event event) {
    Frame frame(ocean::with_mesh_for_lamps(scene::with_emitter_parts(state)));
    frame.chains.clear();
    for (std::size_t i = 0; i < frame.scene.state.lights.size(); ++i)
        frame.chains.push_back({static_cast<int>(i), event});
    return frame;
}

}  // namespace dapple::test
