#include "render/flat_water.h"

#include <cmath>
#include <limits>

#include "optics/optics.h"
#include "scene/area_light.h"

namespace dapple::render {
namespace {

using optics::f64::fresnel_transmittance;
using optics::f64::refracted_direction;
using optics::f64::transmitted_cosine;

constexpr glm::dvec3 kUp{0, 1, 0};

/// sin of the angle in the air for a ray from height `a` above the plane to depth `b` below it, `r` away. The
/// horizontal way a tan i + b tan t grows with sin i, so bisection finds its only root; 60 halvings use up a
/// double.
double entry_sine(double a, double b, double r, double n) {
    double low = 0, high = 1;
    for (int step = 0; step < 60; ++step) {
        const double s = 0.5 * (low + high);
        const double way = a * s / std::sqrt((1 - s) * (1 + s)) + b * s / std::sqrt((n - s) * (n + s));
        (way < r ? low : high) = s;
    }
    return 0.5 * (low + high);
}

FlatWaterLight from_sun(const scene::Light& light, glm::dvec3 receiver, double n) {
    FlatWaterLight result{};
    refracted_direction(light.direction, kUp, 1 / n, result.direction);
    const double cos_i = -light.direction.y, cos_t = -result.direction.y;
    result.from = light.direction;
    result.source_distance = std::numeric_limits<double>::infinity();
    result.water_distance = -receiver.y / cos_t;
    result.entry = receiver - result.water_distance * result.direction;
    result.transport = fresnel_transmittance(cos_i, cos_t, 1 / n) * cos_i / cos_t;
    return result;
}

FlatWaterLight from_point(const scene::Light& light, glm::dvec3 receiver, double n) {
    const double a = light.position.y, b = -receiver.y;
    const glm::dvec3 offset(receiver.x - light.position.x, 0, receiver.z - light.position.z);
    const double r = glm::length(offset);
    const double sin_i = entry_sine(a, b, r, n);
    const double cos_i = std::sqrt((1 - sin_i) * (1 + sin_i));
    const double cos_t = transmitted_cosine(cos_i, 1 / n);
    const glm::dvec3 outward = r > 0 ? offset / r : glm::dvec3(1, 0, 0);
    FlatWaterLight result{};
    result.from = sin_i * outward - cos_i * kUp;
    result.direction = (sin_i / n) * outward - cos_t * kUp;
    result.source_distance = a / cos_i;
    result.water_distance = b / cos_t;
    result.entry = light.position + result.source_distance * result.from;
    result.entry.y = 0;
    const double way_slope = a / (cos_i * cos_i * cos_i) + b / (n * cos_t * cos_t * cos_t);  // d(r)/d(sin i)
    // r / sin i, which stays finite on the axis.
    const double way_over_sine = a / cos_i + b / (n * cos_t);
    const double transmittance = fresnel_transmittance(cos_i, cos_t, 1 / n);
    // Between cones i and i + di: flux I T 2 pi sin i di, d(sin i) = cos i di, area 2 pi r dr on a level
    // plane.
    const double level = transmittance / (way_over_sine * way_slope * cos_i);
    result.transport = level / cos_t * spot_falloff(light, result.from);
    return result;
}

}  // namespace

double spot_falloff(const scene::Light& light, glm::dvec3 direction) {
    const double cosine = glm::dot(direction, light.direction);
    if (scene::is_area(light)) return std::max(0.0, cosine);
    if (light.type != scene::LightType::spot) return 1;
    const double outer = std::cos(light.cone_angle);
    const double inner = std::cos(std::max(0.0, light.cone_angle - light.falloff_angle));
    return optics::f64::spot_light_falloff(cosine, outer, inner);
}

std::optional<FlatWaterLight> through_flat_water(const scene::Light& light, glm::dvec3 receiver,
                                                 double refractive_index) {
    if (receiver.y >= 0) return std::nullopt;
    if (light.type == scene::LightType::sun) {
        if (light.direction.y >= 0) return std::nullopt;
        return from_sun(light, receiver, refractive_index);
    }
    if (light.position.y <= 0) return std::nullopt;
    const FlatWaterLight result = from_point(light, receiver, refractive_index);
    if (result.transport <= 0) return std::nullopt;
    return result;
}

}  // namespace dapple::render
