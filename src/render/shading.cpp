#include "render/shading.h"

#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>

#include "base/parallel.h"
#include "light/spot_picture.h"
#include "render/flat_water.h"
#include "scene/area_light.h"

namespace dapple::render {
namespace {

constexpr std::size_t kTile = 1024;
/// Shadow rays start this share of the receiver's distance from the origin (and at least 1e-6 m) off the
/// surface: a few units in the last place of its float position.
constexpr float kShadowOffset = 4e-7f;
/// Hemispherical transmittance of flat water of index 1.333 for diffuse light from the air: 1 - 0.066.
constexpr double kDiffuseTransmittance = 0.934;

/// A receiver's shadow ray and what arrives if nothing is in its way.
struct Candidate {
    std::size_t pixel;
    rays::Ray ray;
    glm::vec3 irradiance;
};

void add_unoccluded(const rays::RayScene& rays, const std::vector<Candidate>& candidates,
                    std::vector<std::uint8_t>& blocked) {
    std::vector<rays::Ray> shadow_rays;
    shadow_rays.reserve(candidates.size());
    for (const Candidate& candidate : candidates) shadow_rays.push_back(candidate.ray);
    std::vector<std::uint8_t> occluded(candidates.size(), 0);
    rays.occluded_by_objects(shadow_rays, occluded);
    for (std::size_t i = 0; i < occluded.size(); ++i) blocked[i] |= occluded[i];
}

glm::vec3 shadow_origin(const view::ReceiverLayer& layer, std::size_t pixel) {
    const glm::vec3 position = layer.position[pixel];
    const float offset = std::max(1e-6f, kShadowOffset * glm::length(position));
    return position + offset * layer.geometric_normal[pixel];
}

bool inside_rectangle(const scene::Extent& extent, glm::dvec3 position) {
    const glm::dvec2 offset = glm::abs(glm::dvec2(position.x, position.z) - extent.center);
    return offset.x <= 0.5 * extent.size.x && offset.y <= 0.5 * extent.size.y;
}

bool in_extent(const scene::Extent& extent, glm::dvec3 position) {
    return extent.kind == scene::ExtentKind::open_water || inside_rectangle(extent, position);
}

/// Runs `body(pixel range, irradiance)` tile by tile in parallel.
std::vector<glm::vec3> by_tiles(
    const view::ReceiverLayer& layer,
    const std::function<void(std::size_t, std::size_t, std::vector<glm::vec3>&)>& body) {
    std::vector<glm::vec3> irradiance(layer.pixels(), glm::vec3(0));
    parallel_for(layer.pixels(), kTile,
                 [&](std::size_t begin, std::size_t end) { body(begin, end, irradiance); });
    return irradiance;
}

/// m: across a light's direction, of the square as large as the part of the surface that the pixel sees.
double seen_width(const view::ReceiverLayer& layer, std::size_t pixel, glm::dvec3 direction) {
    const glm::vec3 area = glm::cross(layer.footprint_u[pixel], layer.footprint_v[pixel]);
    return std::sqrt(std::abs(glm::dot(glm::dvec3(area), direction)));
}

/// Direct light of one source at a pixel's receiver; empty irradiance where it faces away. A sun's light has
/// the `direction`, a lamp's comes `from` a point, m.
Candidate direct_candidate(const scene::FrameScene& scene, const media::Media& media,
                           const view::ReceiverLayer& layer, std::size_t pixel, const scene::Light& light,
                           const light::SpotPicture& picture, glm::dvec3 direction, glm::dvec3 from) {
    Candidate candidate{pixel, {}, glm::vec3(0)};
    const glm::dvec3 position = glm::dvec3(layer.position[pixel]) + scene.origin;
    glm::dvec3 strength = light.irradiance;
    double distance = std::numeric_limits<double>::infinity();
    auto far = static_cast<float>(distance);
    if (light.type != scene::LightType::sun) {
        const glm::dvec3 way = position - from;
        distance = glm::length(way);
        if (distance == 0) return candidate;
        direction = way / distance;
        strength = light.intensity * (spot_falloff(light, direction) / (distance * distance));
        if (picture.exists())
            strength *= picture.towards(direction, seen_width(layer, pixel, direction) / distance);
        far = static_cast<float>(distance * (1 - 1e-6));
    }
    const double facing = -glm::dot(direction, glm::dvec3(layer.geometric_normal[pixel]));
    const double cosine = -glm::dot(direction, glm::dvec3(layer.shading_normal[pixel]));
    if (facing <= 0 || cosine <= 0) return candidate;
    const bool in_water = layer.flags[pixel] & view::kInWater;
    if (in_water || media.bounded(false)) {
        strength *=
            glm::exp(-media.optical_depth(glm::dvec3(layer.position[pixel]), -direction, distance, in_water));
    }
    candidate.irradiance = glm::vec3(cosine * strength);
    candidate.ray = {shadow_origin(layer, pixel), 0, glm::vec3(-direction), far};
    return candidate;
}

}  // namespace

glm::dvec3 sun_direction(const scene::Light& light, int sample, int samples) {
    if (light.angular_diameter <= 0 || samples == 1) return light.direction;
    constexpr double golden_angle = 2.399963229728653;
    const double radius = std::tan(0.5 * light.angular_diameter) * std::sqrt((sample + 0.5) / samples);
    const double angle = golden_angle * sample;
    const glm::dvec3 helper = std::abs(light.direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(helper, light.direction));
    const glm::dvec3 v = glm::cross(light.direction, u);
    return glm::normalize(light.direction + radius * (std::cos(angle) * u + std::sin(angle) * v));
}

glm::dvec3 lamp_position(const scene::FrameState& state, std::size_t index, int sample) {
    const scene::Light& lamp = state.lights[index];
    const int samples = state.clip.samples;
    if (lamp.part.count == 0 || samples == 1) return lamp.position;
    const double number = static_cast<double>(index) * samples + sample;
    return scene::emitter_point(lamp, glm::fract(0.5 + number * kEvenStep));
}

bool light_in_water(const scene::FrameState& state, const scene::Light& light) {
    return light.type != scene::LightType::sun && state.water && light.position.y < 0 &&
           in_extent(state.water->extent, light.position);
}

std::vector<glm::vec3> direct_irradiance(const scene::FrameScene& scene, const media::Media& media,
                                         const rays::RayScene& rays, const view::ReceiverLayer& layer) {
    const std::vector<light::SpotPicture> pictures = light::spot_pictures(scene);
    return by_tiles(layer, [&](std::size_t begin, std::size_t end, std::vector<glm::vec3>& irradiance) {
        std::vector<Candidate> candidates;
        for (std::size_t index = 0; index < scene.state.lights.size(); ++index) {
            const scene::Light& light = scene.state.lights[index];
            const bool in_water = light_in_water(scene.state, light);
            const glm::dvec3 direction = light.type == scene::LightType::sun
                                             ? sun_direction(light, layer.sample, scene.state.clip.samples)
                                             : light.direction;
            const glm::dvec3 from = lamp_position(scene.state, index, layer.sample);
            candidates.clear();
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                const std::uint32_t flags = layer.flags[pixel];
                if (!(flags & view::kReceiver) || in_water != bool(flags & view::kInWater)) continue;
                const Candidate candidate =
                    direct_candidate(scene, media, layer, pixel, light, pictures[index], direction, from);
                if (candidate.irradiance != glm::vec3(0)) candidates.push_back(candidate);
            }
            std::vector<std::uint8_t> blocked(candidates.size(), 0);
            add_unoccluded(rays, candidates, blocked);
            for (std::size_t i = 0; i < candidates.size(); ++i) {
                if (!blocked[i]) irradiance[candidates[i].pixel] += candidates[i].irradiance;
            }
        }
    });
}

std::vector<glm::vec3> flat_water_irradiance(const scene::FrameScene& scene, const media::Media& media,
                                             const rays::RayScene& rays, const view::ReceiverLayer& layer,
                                             const std::vector<std::uint8_t>& covered) {
    const std::vector<light::SpotPicture> pictures = light::spot_pictures(scene);
    return by_tiles(layer, [&](std::size_t begin, std::size_t end, std::vector<glm::vec3>& irradiance) {
        std::vector<Candidate> in_water, in_air;
        for (std::size_t index = 0; index < scene.state.lights.size(); ++index) {
            const scene::Light& light = scene.state.lights[index];
            in_water.clear();
            in_air.clear();
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                constexpr std::uint32_t wanted = view::kReceiver | view::kInWater;
                if ((layer.flags[pixel] & wanted) != wanted) continue;
                const scene::Water& water = *scene.state.water;
                const glm::dvec3 position = glm::dvec3(layer.position[pixel]) + scene.origin;
                const auto flat = through_flat_water(light, position, water.refractive_index);
                if (!flat || !in_extent(water.extent, flat->entry)) continue;
                if (covered[pixel] && inside_rectangle(water.extent, flat->entry)) continue;
                const double facing = -glm::dot(flat->direction, glm::dvec3(layer.geometric_normal[pixel]));
                const double cosine = -glm::dot(flat->direction, glm::dvec3(layer.shading_normal[pixel]));
                if (facing <= 0 || cosine <= 0) continue;
                glm::dvec3 strength =
                    light.type == scene::LightType::sun ? light.irradiance : light.intensity;
                // As wide as the pixel is seen from the point that the light seems to come from.
                if (pictures[index].exists())
                    strength *= pictures[index].towards(
                        flat->from, seen_width(layer, pixel, flat->direction) * std::sqrt(flat->transport));
                const glm::dvec3 depth = media.optical_depth(glm::dvec3(layer.position[pixel]),
                                                             -flat->direction, flat->water_distance, true) +
                                         media.optical_depth(flat->entry - scene.origin, -flat->from,
                                                             flat->source_distance, false);
                const glm::vec3 arriving(cosine * flat->transport * strength * glm::exp(-depth));
                const glm::vec3 entry(flat->entry - scene.origin);
                in_water.push_back({pixel,
                                    {shadow_origin(layer, pixel), 0, glm::vec3(-flat->direction),
                                     static_cast<float>(flat->water_distance)},
                                    arriving});
                in_air.push_back(
                    {pixel,
                     {entry, 0, glm::vec3(-flat->from), static_cast<float>(flat->source_distance)},
                     arriving});
            }
            std::vector<std::uint8_t> blocked(in_water.size(), 0);
            add_unoccluded(rays, in_water, blocked);
            add_unoccluded(rays, in_air, blocked);
            for (std::size_t i = 0; i < in_water.size(); ++i) {
                if (!blocked[i]) irradiance[in_water[i].pixel] += in_water[i].irradiance;
            }
        }
    });
}

std::vector<glm::vec3> sky_irradiance(const scene::FrameScene& scene, const view::ReceiverLayer& layer) {
    const glm::dvec3 radiance = scene.state.sky.radiance;
    if (radiance == glm::dvec3(0)) return std::vector<glm::vec3>(layer.pixels(), glm::vec3(0));
    return by_tiles(layer, [&](std::size_t begin, std::size_t end, std::vector<glm::vec3>& irradiance) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            if (!(layer.flags[pixel] & view::kReceiver)) continue;
            const double upward = 0.5 * (1 + static_cast<double>(layer.shading_normal[pixel].y));
            glm::dvec3 arriving = glm::pi<double>() * upward * radiance;
            const glm::dvec3 position = glm::dvec3(layer.position[pixel]) + scene.origin;
            const bool glass_in_water = (layer.flags[pixel] & view::kInGlass) && scene.state.water &&
                                        position.y < 0 && in_extent(scene.state.water->extent, position);
            if ((layer.flags[pixel] & view::kInWater) || glass_in_water) {
                const scene::Water& water = *scene.state.water;
                const double depth = std::max(0.0, -position.y);
                const glm::dvec3 attenuation =
                    glm::mix(water.diffuse_attenuation, water.absorption,
                             glm::lessThan(water.diffuse_attenuation, glm::dvec3(0)));
                arriving *= kDiffuseTransmittance * glm::exp(-depth * attenuation);
            }
            irradiance[pixel] = glm::vec3(arriving);
        }
    });
}

}  // namespace dapple::render
