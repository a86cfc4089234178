#include "methods/reference/light_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/hash.h"
#include "methods/reference/own_optics.h"
#include "methods/reference/random_stream.h"

namespace dapple::reference {

LightSamples::LightSamples(const scene::FrameScene& scene, std::uint32_t light, int object)
    : scene_(scene),
      source_(light + static_cast<std::uint32_t>(scene.state.lights.size()) *
                          static_cast<std::uint32_t>(object + 1)) {}

double LightSamples::number(const LightPass& pass, std::size_t stratum, Dimension dimension) const {
    const scene::FrameState& state = scene_.state;
    const std::uint64_t seed = state.clip.seed + 0x9e3779b97f4a7c15 * pass.strata;
    return hash_uniform(seed, static_cast<std::uint64_t>(state.frame), pass.number << 40 | stratum,
                        source_ * kDimensions + static_cast<std::uint32_t>(dimension));
}

std::uint64_t LightSamples::ray(const LightPass& pass, std::size_t stratum) const {
    // 8 bits of the source's number stand below the stratum, the others above the pass's of 24 bits.
    const std::uint64_t set = static_cast<std::uint64_t>(source_ >> 8) << 24 | pass.number;
    return branched(branched(pass.strata, set), stratum << 8 | (source_ & 0xff));
}

StrataGrid::StrataGrid(std::size_t strata, double aspect) {
    const auto wanted = static_cast<double>(strata);
    columns = strata;
    if (aspect > 0) columns = static_cast<std::size_t>(std::max(1.0, std::round(std::sqrt(wanted * aspect))));
    rows = (strata + columns - 1) / columns;
}

AcrossAxis::AcrossAxis(const glm::dvec3& axis) {
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    u = normalize(cross(axis, other));
    v = cross(axis, u);
}

SunRay sun_ray(const scene::Light& sun, double random_radius, double random_angle) {
    if (!(sun.angular_diameter > 0)) return {sun.direction, 1};
    const double radius = std::sin(0.5 * sun.angular_diameter) * std::sqrt(random_radius);
    const double angle = 2 * std::numbers::pi * random_angle;
    const AcrossAxis across(sun.direction);
    const double cosine = std::sqrt(1 - radius * radius);
    return {
        radius * std::cos(angle) * across.u + radius * std::sin(angle) * across.v + cosine * sun.direction,
        1 / cosine};
}

glm::dvec3 emission_point(const scene::FrameScene& scene, const scene::Light& lamp, double random_first,
                          double random_second) {
    const scene::EmitterPart& part = lamp.part;
    if (part.count == 0) return lamp.position - scene.origin;
    const double first = part.low.x + random_first * (part.high.x - part.low.x);
    const double second = part.low.y + random_second * (part.high.y - part.low.y);
    // From the middle of the emitter, to the right of where it heads and up; what faces straight up or down
    // heads to -z.
    const glm::dvec3& axis = lamp.direction;
    const bool heads = std::hypot(axis.x, axis.z) > 1e-6;
    const double heading = heads ? std::atan2(axis.z, axis.x) : -0.5 * std::numbers::pi;
    const glm::dvec3 right(-std::sin(heading), 0, std::cos(heading));
    const glm::dvec3 up = normalize(cross(right, axis));
    double x = (first - 0.5) * lamp.size.x, y = (second - 0.5) * lamp.size.y;
    if (lamp.type == scene::LightType::disc) {
        x = lamp.radius * std::sqrt(first) * std::cos(2 * std::numbers::pi * second);
        y = lamp.radius * std::sqrt(first) * std::sin(2 * std::numbers::pi * second);
    }
    const double distance = std::hypot(x, y), angle = std::atan2(y, x) - lamp.roll;
    return part.center - scene.origin + distance * std::cos(angle) * right + distance * std::sin(angle) * up;
}

glm::dvec3 intensity_towards(const scene::Light& light, const OwnPicture& picture,
                             const glm::dvec3& direction) {
    if (light.part.count > 0)  // Lambert's law; the other side is dark
        return std::max(0.0, dot(direction, light.direction)) * light.intensity;
    if (light.type != scene::LightType::spot) return light.intensity;
    const double share = spot_share(dot(direction, light.direction), light.cone_angle, light.falloff_angle);
    return share * light.intensity * picture.towards(direction);
}

}  // namespace dapple::reference
