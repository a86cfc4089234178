#include "methods/reference/light_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "methods/reference/own_optics.h"

namespace dapple::reference {
namespace {

constexpr int kMostEvents = 8;
/// Branches of a later crossing that carry less than this share of what the light started with end.
constexpr double kLeastShare = 1e-4;

}  // namespace

LightTracer::LightTracer(const scene::FrameScene& scene, const rays::RayScene& rays,
                         const std::vector<light::Chain>& chains, const ReceiverCharts& charts,
                         ReferenceOptions options)
    : scene_(scene),
      rays_(rays),
      charts_(charts),
      options_(options),
      media_(scene),
      water_(scene),
      geometry_(scene) {
    for (std::uint32_t i = 0; i < scene.state.lights.size(); ++i) {
        LitBy by{Lamp(scene, rays, water_, media_, i)};
        for (const light::Chain& chain : chains) {
            if (chain.light != static_cast<int>(i)) continue;
            (chain.event == light::Event::transmission ? by.transmission : by.reflection) = true;
        }
        if (by.transmission || by.reflection) lights_.push_back(by);
    }
    // Where the eye sees what scatters, waves may come between.
    const bool scatters = media_.scatters(false) || media_.scatters(true);
    if (meets_water_again() || (scatters && water_.surface().highest() > 0)) water_.build();
}

/// Whether some ray may meet the water once more, from bounds of the slope: a ray that leaves a height field
/// steeper than any of its chords never comes back.
bool LightTracer::meets_water_again() const {
    const std::vector<scene::Object>& objects = scene_.state.objects;
    const bool mirror = std::any_of(objects.begin(), objects.end(),
                                    [](const scene::Object& object) { return object.material.mirror; });
    if (!water_.surface().is_height_field() || (mirror && options_.mirrors)) return true;
    if (water_.surface().steepest() == 0) return false;
    const double tilt = std::atan(water_.surface().steepest());
    const double index = scene_.state.water->refractive_index + scene_.state.water->dispersion;
    return std::any_of(lights_.begin(), lights_.end(), [&](const LitBy& by) {
        // Refraction into the water ends within the critical angle of the tilted normal.
        const double critical = std::asin(std::min(1.0, 1 / index));
        const double descent = 0.5 * std::numbers::pi - critical - tilt;
        return by.lamp.waves_may_shadow() || (by.reflection && by.lamp.lowest_elevation() <= 3 * tilt) ||
               (by.transmission && (by.lamp.may_shine_from_below() || descent <= tilt));
    });
}

std::size_t LightTracer::strata(const LightPass& pass) const {
    return lights_.empty() ? 0 : lights_.front().lamp.strata(pass);
}

/// Adds the rays that go on from a point of the water; `from` holds what arrives, its own `events` counted.
void LightTracer::add_branches(const LightRay& from, const glm::dvec3& position,
                               const glm::dvec3& geometric_normal, const glm::dvec3& shading_normal,
                               bool refract, bool reflect, std::vector<LightRay>& next) const {
    const double side = dot(from.direction, geometric_normal) <= 0 ? 1 : -1;
    const bool from_air = side > 0;
    const double above = from_air ? 1 : from.index, below = from_air ? from.index : 1;
    const glm::dvec3 geometric = side * geometric_normal;
    glm::dvec3 normal = side * shading_normal;
    Split parts = split(from.direction, normal, above, below);
    // An interpolated normal may send light to the wrong side of its triangle: then the triangle's counts.
    if (dot(from.direction, normal) >= 0 || dot(parts.reflected, geometric) <= 0 ||
        (parts.transmittance > 0 && dot(parts.refracted, geometric) >= 0)) {
        parts = split(from.direction, geometric, above, below);
    }
    LightRay ray = from;
    ray.position = position;
    ray.lift = glm::dvec3(0);
    ray.left_water = true;
    const auto add = [&](double share, const glm::dvec3& direction, bool in_water) {
        ray.power = share * from.power;
        if (!(mean(ray.power) > from.least_power)) return;
        ray.direction = direction;
        ray.clear = water_.built() ? water_.clear_of_water(position, direction, geometric) : 0;
        ray.in_water = in_water;
        ray.random = branched(from.random, in_water ? 1 : 0);
        next.push_back(ray);
    };
    if (refract) add(parts.transmittance, parts.refracted, from_air);
    if (reflect) add(parts.reflectance, parts.reflected, !from_air);
}

void LightTracer::meet_water(const LitBy& by, const Incoming& incoming, std::vector<LightRay>& rays) const {
    const scene::Water& water = *scene_.state.water;
    LightRay ray;
    ray.direction = incoming.direction;
    ray.events = 1;
    ray.random = incoming.random;
    ray.stratum = incoming.stratum;
    const auto add = [&](const glm::dvec3& power, double index) {
        ray.power = power;
        ray.index = index;
        const glm::dvec3 geometric = normalize(incoming.point.area);
        const std::size_t first = rays.size();
        add_branches(ray, incoming.point.position, geometric, incoming.point.normal, by.transmission,
                     by.reflection, rays);
        for (std::size_t i = first; i < rays.size(); ++i) rays[i].least_power = kLeastShare * mean(power);
    };
    if (water.dispersion == 0) {
        add(incoming.power, water.refractive_index);
        return;
    }
    for (std::uint8_t channel = 0; channel < 3; ++channel) {
        glm::dvec3 power(0);
        power[channel] = incoming.power[channel];
        ray.random = branched(incoming.random, 2 + std::uint64_t{channel});
        add(power, water.refractive_index + 0.5 * (channel - 1) * water.dispersion);
    }
}

void LightTracer::follow(std::vector<LightRay>& rays, Harvest& harvest) const {
    std::vector<rays::Ray> traced;
    std::vector<rays::Hit> objects, water, water_hits;
    std::vector<std::size_t> tested;
    std::vector<LightRay> next;
    while (!rays.empty()) {
        traced.clear();
        for (const LightRay& ray : rays)
            traced.push_back(
                float_ray(ray.position + ray.lift, ray.direction, 0, std::numeric_limits<float>::infinity()));
        objects.resize(rays.size());
        rays_.intersect_objects(traced, objects);
        water.assign(rays.size(), rays::Hit{});
        if (water_.built()) {
            tested.clear();
            std::size_t count = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (rays[i].left_water && !water_.may_return(rays[i].direction)) continue;
                traced[count] = traced[i];
                traced[count].near = static_cast<float>(rays[i].clear);
                traced[count++].far = objects[i].distance;
                tested.push_back(i);
            }
            water_hits.resize(count);
            water_.intersect(std::span(traced).first(count), water_hits);
            for (std::size_t i = 0; i < count; ++i) water[tested[i]] = water_hits[i];
        }
        next.clear();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (water[i].primitive != rays::kNoHit)
                cross_again(rays[i], water[i], next, harvest);
            else if (objects[i].primitive != rays::kNoHit)
                arrive(rays[i], objects[i], next, harvest);
            else
                go(rays[i], std::numeric_limits<double>::infinity(), harvest);
        }
        rays.swap(next);
    }
}

/// To the end of its way, which is noted.
void LightTracer::go(LightRay& ray, double distance, Harvest& harvest) const {
    distance = std::max(0.0, distance);
    if (harvest.ways != nullptr && finite(ray.power))
        harvest.ways->push_back({ray.position, ray.direction, distance, ray.power, ray.in_water,
                                 branched(ray.random, 3), ray.stratum});
    if (std::isinf(distance)) return;
    RandomStream random{scene_.state.clip.seed, static_cast<std::uint64_t>(scene_.state.frame), ray.random};
    ray.power *= harvest.probe.transmittance(ray.position, ray.direction, distance, ray.in_water, random);
}

void LightTracer::arrive(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next,
                         Harvest& harvest) const {
    const view::SurfacePoint point = geometry_.object_point(hit, ray.position, ray.direction);
    go(ray, point.distance, harvest);
    const scene::Material& material = scene_.state.objects[hit.object].material;
    if (!material.mirror) {
        const ChartPlace place = charts_.place(hit.object, hit.primitive, point.position, -ray.direction);
        if (place.density > 0 && finite(ray.power)) harvest.arrivals.push_back({place, ray.power});
        return;
    }
    if (!options_.mirrors || ray.events == kMostEvents) return;
    const double side = dot(ray.direction, point.geometric_normal) <= 0 ? 1 : -1;
    const glm::dvec3 geometric = side * point.geometric_normal;
    glm::dvec3 normal = side * point.shading_normal;
    const auto mirrored = [&] { return ray.direction - 2 * dot(ray.direction, normal) * normal; };
    if (dot(mirrored(), geometric) <= 0) normal = geometric;
    ray.direction = normalize(mirrored());
    ray.position = point.position;
    ray.lift = rounding_of(point.position) * geometric;
    ray.clear = 0;
    ray.power *= material.color;
    ray.left_water = false;
    ray.random = branched(ray.random, 2);
    ++ray.events;
    if (mean(ray.power) > ray.least_power) next.push_back(ray);
}

void LightTracer::cross_again(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next,
                              Harvest& harvest) const {
    const WaterCrossing crossing = water_.crossing(ray.position, ray.direction, hit);
    go(ray, crossing.distance, harvest);
    if (!options_.second_crossings || ray.events == kMostEvents) return;
    ++ray.events;
    add_branches(ray, crossing.position, crossing.geometric_normal, crossing.shading_normal, true, true,
                 next);
}

void LightTracer::trace(const LightPass& pass, std::size_t light, std::size_t begin, std::size_t end,
                        std::vector<Arrival>& arrivals, std::vector<LightWay>* ways) const {
    const LitBy& by = lights_[light];
    const std::vector<Incoming> incoming = by.lamp.shine(pass, begin, end);
    std::vector<LightRay> rays;
    rays.reserve(2 * incoming.size());
    for (const Incoming& lit : incoming) meet_water(by, lit, rays);
    Harvest harvest{arrivals, ways, MediaProbe(media_)};
    follow(rays, harvest);
}

}  // namespace dapple::reference
