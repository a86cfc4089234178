#include "methods/reference/light_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "methods/reference/own_optics.h"

namespace dapple::reference {
namespace {

constexpr int kMostEvents = 16;
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
      geometry_(scene),
      glass_(scene) {
    // Whether lamps stand in the water is asked of its surface.
    if (water_.exists() && glass_.any()) water_.build();
    for (const light::Chain& chain : chains) {
        if (chain.object == light::kWater && !water_.exists()) continue;
        const auto light = static_cast<std::uint32_t>(chain.light);
        auto source = std::find_if(sources_.begin(), sources_.end(), [&](const Source& known) {
            return known.light == light && known.object == chain.object;
        });
        if (source == sources_.end()) {
            if (chain.object == light::kWater)
                sources_.push_back({Lamp(scene, rays, water_, glass_, media_, light), light, chain.object});
            else
                sources_.push_back(
                    {GlassLight(scene, rays, water_, glass_, light, static_cast<std::uint32_t>(chain.object)),
                     light, chain.object});
            source = sources_.end() - 1;
        }
        (chain.event == light::Event::transmission ? source->transmission : source->reflection) = true;
    }
    // Where the eye sees what scatters, waves may come between.
    const bool scatters = media_.scatters(false) || media_.scatters(true);
    if (water_.exists() && !water_.built() &&
        (meets_water_again() || (scatters && water_.surface().highest() > 0)))
        water_.build();
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
    return std::any_of(sources_.begin(), sources_.end(), [&](const Source& source) {
        const auto& lamp = std::get<Lamp>(source.lamp);  // without glass
        // Refraction into the water ends within the critical angle of the tilted normal.
        const double critical = std::asin(std::min(1.0, 1 / index));
        const double descent = 0.5 * std::numbers::pi - critical - tilt;
        return lamp.waves_may_shadow() || (source.reflection && lamp.lowest_elevation() <= 3 * tilt) ||
               (source.transmission && (lamp.may_shine_from_below() || descent <= tilt));
    });
}

double LightTracer::aspect(std::size_t source) const {
    return std::visit([](const auto& lamp) { return lamp.aspect(); }, sources_[source].lamp);
}

std::size_t LightTracer::strata(const LightPass& pass, std::size_t source) const {
    return std::visit([&](const auto& lamp) { return lamp.strata(pass); }, sources_[source].lamp);
}

LightTracer::Interface LightTracer::water_interface(const LightRay& ray, const glm::dvec3& position,
                                                    const glm::dvec3& geometric,
                                                    const glm::dvec3& shading) const {
    return {position, geometric, shading, 1, ray.index};
}

/// What lies about a body is what the ray came through; light from inside learns it where it comes out.
LightTracer::Interface LightTracer::glass_interface(const LightRay& ray, std::uint32_t object,
                                                    const view::SurfacePoint& point) const {
    Interface surface{point.position, point.geometric_normal, point.shading_normal};
    surface.glass = object;
    surface.inside = glass_.index(object);
    surface.outside_in_water =
        ray.glass == object
            ? water_.in_water(point.position + rounding_of(point.position) * point.geometric_normal)
            : ray.in_water;
    surface.outside = surface.outside_in_water ? ray.index : 1;
    return surface;
}

/// Adds the rays that go on from a point of a surface; `from` holds what arrives, its own `events` counted.
void LightTracer::add_branches(const LightRay& from, const Interface& surface, bool refract, bool reflect,
                               Work& work) const {
    const double side = dot(from.direction, surface.geometric_normal) <= 0 ? 1 : -1;
    const bool from_outside = side > 0;
    const double before = from_outside ? surface.outside : surface.inside;
    const double beyond = from_outside ? surface.inside : surface.outside;
    const glm::dvec3 geometric = side * surface.geometric_normal;
    glm::dvec3 normal = side * surface.shading_normal;
    Split parts = split(from.direction, normal, before, beyond);
    // An interpolated normal may send light to the wrong side of its triangle: then the triangle's counts.
    if (dot(from.direction, normal) >= 0 || dot(parts.reflected, geometric) <= 0 ||
        (parts.transmittance > 0 && dot(parts.refracted, geometric) >= 0)) {
        parts = split(from.direction, geometric, before, beyond);
    }
    const bool water = surface.glass == kNoGlass;
    LightRay ray = from;
    ray.position = surface.position;
    ray.left_water = water;
    const auto add = [&](double share, const glm::dvec3& direction, bool to_inside) {
        ray.power = share * from.power;
        if (from.events == 1) work.harvest.account.emitted += mean(ray.power);
        if (!(mean(ray.power) > from.least_power)) {
            work.harvest.account.weak += mean(ray.power);
            return;
        }
        ray.direction = direction;
        ray.lift = glm::dvec3(0);
        ray.clear = 0;
        if (water) {
            ray.clear = water_.built() ? water_.clear_of_water(ray.position, direction, geometric) : 0;
            ray.in_water = to_inside;
        } else {
            ray.lift = (to_inside ? -1 : 1) * rounding_of(ray.position) * surface.geometric_normal;
            ray.glass = to_inside ? surface.glass : kNoGlass;
            ray.in_water = !to_inside && surface.outside_in_water;
        }
        ray.random = branched(from.random, (water ? 0u : 4u) + (to_inside ? 1u : 0u));
        work.next.push_back(ray);
    };
    if (refract) add(parts.transmittance, parts.refracted, from_outside);
    if (reflect) add(parts.reflectance, parts.reflected, !from_outside);
}

/// The first event, of each colour apart where the water parts them. `interface` gives the surface for a ray.
template <class Meet>
void LightTracer::start(const Source& source, LightRay ray, const glm::dvec3& power, const Meet& interface,
                        Work& work) const {
    ray.events = 1;
    const auto add = [&](const glm::dvec3& part, double index) {
        ray.power = part;
        ray.index = index;
        const std::size_t first = work.next.size();
        add_branches(ray, interface(ray), source.transmission, source.reflection, work);
        for (std::size_t i = first; i < work.next.size(); ++i)
            work.next[i].least_power = kLeastShare * mean(part);
    };
    const std::optional<scene::Water>& water = scene_.state.water;
    if (!water || water->dispersion == 0) {
        add(power, water ? water->refractive_index : 1);
        return;
    }
    const std::uint64_t random = ray.random;
    for (std::uint8_t channel = 0; channel < 3; ++channel) {
        glm::dvec3 part(0);
        part[channel] = power[channel];
        ray.random = branched(random, 2 + std::uint64_t{channel});
        add(part, water->refractive_index + 0.5 * (channel - 1) * water->dispersion);
    }
}

void LightTracer::follow(std::vector<LightRay> rays, Work& work) const {
    std::vector<rays::Ray> traced;
    std::vector<rays::Hit> objects, water, water_hits;
    std::vector<std::size_t> tested;
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
                // Within glass the surface of the water does not exist.
                if (rays[i].glass != kNoGlass) continue;
                if (rays[i].left_water && !water_.may_return(rays[i].direction)) continue;
                traced[count] = traced[i];
                traced[count].near = static_cast<float>(rays[i].clear);
                traced[count++].far = water_before(rays[i], objects[i]);
                tested.push_back(i);
            }
            water_hits.resize(count);
            water_.intersect(std::span(traced).first(count), water_hits);
            for (std::size_t i = 0; i < count; ++i) water[tested[i]] = water_hits[i];
        }
        work.next.clear();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (water[i].primitive != rays::kNoHit)
                cross_again(rays[i], water[i], work);
            else if (objects[i].primitive != rays::kNoHit)
                arrive(rays[i], objects[i], work);
            else if (rays[i].glass != kNoGlass)
                work.harvest.account.astray += mean(rays[i].power);
            else
                go(rays[i], std::numeric_limits<double>::infinity(), work);
        }
        rays.swap(work.next);
    }
}

/// Along a ray that hit `object`, or nothing, how far it may meet the water, m.
float LightTracer::water_before(const LightRay& ray, const rays::Hit& object) const {
    if (object.primitive == rays::kNoHit || !glass_.is_glass(object.object)) return object.distance;
    const auto distance = static_cast<double>(object.distance);
    return static_cast<float>(distance - face_margin(ray.position + distance * ray.direction));
}

/// To the end of its way, which is noted.
void LightTracer::go(LightRay& ray, double distance, Work& work) const {
    distance = std::max(0.0, distance);
    const double before = mean(ray.power);
    if (ray.glass != kNoGlass) {
        ray.power *= glass_.through(ray.glass, distance);
    } else {
        if (work.with_ways && finite(ray.power))
            work.harvest.ways.push_back({ray.position, ray.direction, distance, ray.power, ray.in_water,
                                         branched(ray.random, 3), ray.stratum});
        if (std::isinf(distance)) {
            work.harvest.account.escaped += before;
            return;
        }
        RandomStream random{scene_.state.clip.seed, static_cast<std::uint64_t>(scene_.state.frame),
                            ray.random};
        ray.power *= work.probe.transmittance(ray.position, ray.direction, distance, ray.in_water, random);
    }
    work.harvest.account.absorbed += before - mean(ray.power);
}

void LightTracer::arrive(LightRay ray, const rays::Hit& hit, Work& work) const {
    if (glass_.is_glass(hit.object)) {
        meet_glass(ray, hit, work);
        return;
    }
    const view::SurfacePoint point = geometry_.object_point(hit, ray.position, ray.direction);
    go(ray, point.distance, work);
    const scene::Material& material = scene_.state.objects[hit.object].material;
    if (material.mirror) {
        mirror(ray, point, material.color, work);
        return;
    }
    const ChartPlace place = charts_.place(hit.object, hit.primitive, point.position, -ray.direction);
    if (!(place.density > 0) || !finite(ray.power)) return;
    work.harvest.account.arrived += mean(ray.power);
    work.harvest.arrivals.push_back({place, ray.power});
}

void LightTracer::mirror(LightRay ray, const view::SurfacePoint& point, const glm::dvec3& color,
                         Work& work) const {
    EnergyAccount& account = work.harvest.account;
    if (!options_.mirrors || ray.events == kMostEvents) {
        (options_.mirrors ? account.long_chains : account.left_out) += mean(ray.power);
        return;
    }
    const double side = dot(ray.direction, point.geometric_normal) <= 0 ? 1 : -1;
    const glm::dvec3 geometric = side * point.geometric_normal;
    glm::dvec3 normal = side * point.shading_normal;
    const auto mirrored = [&] { return ray.direction - 2 * dot(ray.direction, normal) * normal; };
    if (dot(mirrored(), geometric) <= 0) normal = geometric;
    ray.direction = normalize(mirrored());
    ray.position = point.position;
    ray.lift = rounding_of(point.position) * geometric;
    ray.clear = 0;
    account.absorbed += mean(ray.power);
    ray.power *= color;
    account.absorbed -= mean(ray.power);
    ray.left_water = false;
    ray.random = branched(ray.random, 2);
    ++ray.events;
    if (mean(ray.power) > ray.least_power)
        work.next.push_back(ray);
    else
        account.weak += mean(ray.power);
}

void LightTracer::meet_glass(LightRay ray, const rays::Hit& hit, Work& work) const {
    EnergyAccount& account = work.harvest.account;
    const bool inside = ray.glass != kNoGlass;
    const view::SurfacePoint point = glass_.point(hit, ray.position, ray.direction, inside);
    // From the wrong side, or through one body into another: the ray slipped out at an edge.
    if ((dot(ray.direction, point.geometric_normal) > 0) != inside || (inside && ray.glass != hit.object)) {
        account.astray += mean(ray.power);
        return;
    }
    go(ray, point.distance, work);
    if (ray.events == kMostEvents) {
        account.long_chains += mean(ray.power);
        return;
    }
    ++ray.events;
    add_branches(ray, glass_interface(ray, hit.object, point), true, true, work);
}

void LightTracer::cross_again(LightRay ray, const rays::Hit& hit, Work& work) const {
    const WaterCrossing crossing = water_.crossing(ray.position, ray.direction, hit);
    go(ray, crossing.distance, work);
    EnergyAccount& account = work.harvest.account;
    if (!options_.second_crossings || ray.events == kMostEvents) {
        (options_.second_crossings ? account.long_chains : account.left_out) += mean(ray.power);
        return;
    }
    ++ray.events;
    add_branches(ray,
                 water_interface(ray, crossing.position, crossing.geometric_normal, crossing.shading_normal),
                 true, true, work);
}

Harvest LightTracer::trace(const LightPass& pass, std::size_t source, std::size_t begin, std::size_t end,
                           bool with_ways) const {
    const Source& by = sources_[source];
    Work work{{}, with_ways, MediaProbe(media_), {}};
    const auto start_of = [](const auto& lit) {
        LightRay ray;
        ray.direction = lit.direction;
        ray.random = lit.random;
        ray.stratum = lit.stratum;
        return ray;
    };
    if (const auto* lamp = std::get_if<Lamp>(&by.lamp)) {
        const std::vector<Incoming> incoming = lamp->shine(pass, begin, end, work.probe);
        work.next.reserve(2 * incoming.size());
        for (const Incoming& lit : incoming) {
            const auto interface = [&](const LightRay& ray) {
                return water_interface(ray, lit.point.position, normalize(lit.point.area), lit.point.normal);
            };
            start(by, start_of(lit), lit.power, interface, work);
        }
    } else {
        const auto& glass = std::get<GlassLight>(by.lamp);
        for (const GlassIncoming& lit : glass.shine(pass, begin, end, work.probe)) {
            LightRay ray = start_of(lit);
            ray.in_water = !lit.inside && lit.in_water;
            ray.glass = lit.inside ? glass.object() : kNoGlass;
            const auto interface = [&](const LightRay& colored) {
                return glass_interface(colored, glass.object(), lit.point);
            };
            start(by, ray, lit.power, interface, work);
        }
    }
    follow(std::move(work.next), work);
    return std::move(work.harvest);
}

}  // namespace dapple::reference
