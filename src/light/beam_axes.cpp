#include "light/beam_axes.h"

#include <algorithm>
#include <cmath>

#include "optics/optics.h"

namespace dapple::light {

std::array<glm::dvec3, kSheetAxes> sheet_axes(glm::dvec3 mean) {
    return {{mean, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {0, 1, 0}, {0, -1, 0}}};
}

glm::dmat3 mesh_frame(glm::dvec3 axis) {
    const glm::dvec3 helper = std::abs(axis.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 a = glm::normalize(helper - glm::dot(helper, axis) * axis);
    return {a, glm::cross(axis, a), axis};
}

std::vector<glm::dvec3> sun_directions(const scene::Light& sun, int samples) {
    if (sun.angular_diameter <= 0 || samples <= 1) return {sun.direction};
    constexpr double golden_angle = 2.399963229728653;
    const glm::dmat3 frame = mesh_frame(sun.direction);
    std::vector<glm::dvec3> directions;
    directions.reserve(static_cast<std::size_t>(samples));
    for (int i = 0; i < samples; ++i) {
        const double radius = std::tan(0.5 * sun.angular_diameter) * std::sqrt((i + 0.5) / samples);
        const double angle = golden_angle * i;
        directions.push_back(
            glm::normalize(frame * glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), 1)));
    }
    return directions;
}

DiscEllipse disc_ellipse(glm::dvec3 direction, double radius, Event event, double refractive_index,
                         const glm::dmat3& world_from_mesh) {
    using namespace optics::f64;
    if (!(radius > 0)) return {};
    const glm::dvec3 up(0, 1, 0), still(0);
    const double eta = 1 / refractive_index;
    const bool transmission = event == Event::transmission;
    glm::dvec3 out = reflected_direction(direction, up);
    if (transmission && !refracted_direction(direction, up, eta, out)) return {};
    const glm::dvec3 local = glm::transpose(world_from_mesh) * out;
    if (!(local.z > kConeCosine)) return {};
    // In the plane of incidence and across it: by symmetry these become the principal axes of the ellipse of
    // a sheet along the mean direction.
    glm::dvec3 across = glm::cross(direction, up);
    across = glm::dot(across, across) > 1e-24 ? glm::normalize(across) : glm::dvec3(1, 0, 0);
    const auto moved = [&](glm::dvec3 change) {
        const glm::dvec3 spread = transmission ? refracted_differential(direction, up, eta, change, still)
                                               : reflected_differential(direction, up, change, still);
        const glm::dvec3 d = glm::transpose(world_from_mesh) * spread;
        return (glm::dvec2(d) - glm::dvec2(local) * (d.z / local.z)) / local.z;
    };
    return {moved(radius * glm::cross(across, direction)), moved(radius * across)};
}

}  // namespace dapple::light
