#include "methods/reference/light_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/hash.h"
#include "methods/reference/own_optics.h"

namespace dapple::reference {
namespace {

constexpr int kMostEvents = 8;
/// Branches of a later crossing that carry less than this share of what the light started with end.
constexpr double kLeastShare = 1e-4;

/// Random numbers of a stratum, by what they are for; each light has kDimensions of its own.
enum Dimension : std::uint32_t { kAlong, kAcross, kFacet, kDiscRadius, kDiscAngle, kDimensions };

double random_number(const scene::FrameState& state, const LightPass& pass, std::uint32_t light,
                     std::size_t stratum, Dimension dimension) {
    const std::uint64_t seed = state.clip.seed + 0x9e3779b97f4a7c15 * pass.strata;
    return hash_uniform(seed, static_cast<std::uint64_t>(state.frame), pass.number << 40 | stratum,
                        light * kDimensions + dimension);
}

double mean(const glm::dvec3& color) {
    return (color.x + color.y + color.z) / 3;
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x + v.y + v.z);
}

/// A direction of the sun's disc, evenly over the disc as seen on a plane that faces it, and the irradiance
/// on a plane across that very direction, over the sun's.
struct SunRay {
    glm::dvec3 direction;
    double irradiance;
};
SunRay sun_ray(const scene::Light& sun, double random_radius, double random_angle) {
    if (!(sun.angular_diameter > 0)) return {sun.direction, 1};
    const double radius = std::sin(0.5 * sun.angular_diameter) * std::sqrt(random_radius);
    const double angle = 2 * std::numbers::pi * random_angle;
    const glm::dvec3 axis = sun.direction;
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 u = normalize(cross(axis, other));
    const glm::dvec3 v = cross(axis, u);
    const double cosine = std::sqrt(1 - radius * radius);
    return {radius * std::cos(angle) * u + radius * std::sin(angle) * v + cosine * axis, 1 / cosine};
}

rays::Ray float_ray(const glm::dvec3& origin, const glm::dvec3& direction, double near, float far) {
    rays::Ray ray;
    ray.origin = glm::vec3(origin);
    ray.direction = glm::vec3(direction);
    ray.near = static_cast<float>(near);
    ray.far = far;
    return ray;
}

}  // namespace

LightTracer::LightTracer(const scene::FrameScene& scene, const rays::RayScene& rays,
                         const std::vector<light::Chain>& chains, const ReceiverCharts& charts,
                         ReferenceOptions options)
    : scene_(scene), rays_(rays), charts_(charts), options_(options), surface_(scene), geometry_(scene) {
    for (std::uint32_t i = 0; i < scene.state.lights.size(); ++i) {
        LitBy by = prepare(i);
        for (const light::Chain& chain : chains) {
            if (chain.light != static_cast<int>(i)) continue;
            (chain.event == light::Event::transmission ? by.transmission : by.reflection) = true;
        }
        if (by.transmission || by.reflection) lights_.push_back(by);
    }
    if (!meets_water_again()) return;
    water_scene_ = scene;
    water_scene_->water = surface_.mesh();
    water_rays_.emplace(*water_scene_);
    water_geometry_.emplace(*water_scene_);
    chord_error_ = surface_.chord_error(*water_scene_->water);
}

double LightTracer::lowest_elevation(const scene::Light& light) const {
    if (light.type == scene::LightType::sun)
        return std::asin(std::clamp(-light.direction.y, -1.0, 1.0)) - 0.5 * light.angular_diameter;
    const scene::Extent& extent = scene_.state.water->extent;
    const glm::dvec2 place(light.position.x, light.position.z);
    const glm::dvec2 reach = glm::abs(place - extent.center) + 0.5 * extent.size;
    return std::atan2(std::abs(light.position.y) - surface_.highest(), length(reach));
}

LightTracer::LitBy LightTracer::prepare(std::uint32_t index) const {
    LitBy by;
    by.light = scene_.state.lights[index];
    by.index = index;
    if (by.light.type == scene::LightType::sun) {
        by.from_below = false;
    } else {
        by.from_above = by.light.position.y > -surface_.highest();
        by.from_below = by.light.position.y < surface_.highest();
    }
    by.waves_may_shadow = lowest_elevation(by.light) <= std::atan(surface_.steepest()) &&
                          (surface_.highest() > 0 || !surface_.is_height_field());
    return by;
}

/// Whether some ray may meet the water once more, from bounds of the slope: a ray that leaves a height field
/// steeper than any of its chords never comes back.
bool LightTracer::meets_water_again() const {
    const std::vector<scene::Object>& objects = scene_.state.objects;
    const bool mirror = std::any_of(objects.begin(), objects.end(),
                                    [](const scene::Object& object) { return object.material.mirror; });
    if (!surface_.is_height_field() || (mirror && options_.mirrors)) return true;
    if (surface_.steepest() == 0) return false;
    const double tilt = std::atan(surface_.steepest());
    const double index = scene_.state.water->refractive_index + scene_.state.water->dispersion;
    return std::any_of(lights_.begin(), lights_.end(), [&](const LitBy& by) {
        // Refraction into the water ends within the critical angle of the tilted normal.
        const double critical = std::asin(std::min(1.0, 1 / index));
        const double descent = 0.5 * std::numbers::pi - critical - tilt;
        return by.waves_may_shadow || (by.reflection && lowest_elevation(by.light) <= 3 * tilt) ||
               (by.transmission && (by.from_below || descent <= tilt));
    });
}

LightTracer::Grid LightTracer::grid(const LightPass& pass) const {
    if (!surface_.is_height_field()) return {pass.strata, 1};
    const glm::dvec2 size = scene_.state.water->extent.size;
    const auto wanted = static_cast<double>(pass.strata);
    const auto columns =
        static_cast<std::size_t>(std::max(1.0, std::round(std::sqrt(wanted * size.x / size.y))));
    return {columns, (pass.strata + columns - 1) / columns};
}

std::size_t LightTracer::strata(const LightPass& pass) const {
    const Grid size = grid(pass);
    return size.columns * size.rows;
}

/// Height fields: a jittered grid over the extent. Triangles: as many equal stretches along their numbers,
/// and a random point of the triangle.
std::vector<LightTracer::WaterPoint> LightTracer::sample_water(const LightPass& pass, std::uint32_t light,
                                                               std::size_t begin, std::size_t end) const {
    const scene::FrameState& state = scene_.state;
    const std::size_t count = end - begin;
    std::vector<WaterPoint> points(count);
    const Grid size = grid(pass);
    if (!surface_.is_height_field()) {
        const scene::TriangleMesh& mesh = water_scene_->water->mesh;
        const double stretch = static_cast<double>(mesh.triangles.size()) / static_cast<double>(size.columns);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t stratum = begin + i;
            const double place =
                stretch * (static_cast<double>(stratum) + random_number(state, pass, light, stratum, kFacet));
            const glm::uvec3 corner =
                mesh.triangles[std::min(mesh.triangles.size() - 1, static_cast<std::size_t>(place))];
            const double root = std::sqrt(random_number(state, pass, light, stratum, kAlong));
            const double v = root * random_number(state, pass, light, stratum, kAcross);
            const glm::dvec3 weight(1 - root, root - v, v);
            const auto at = [&](const std::vector<glm::dvec3>& values) {
                return weight.x * values[corner.x] + weight.y * values[corner.y] +
                       weight.z * values[corner.z];
            };
            const glm::dvec3& a = mesh.positions[corner.x];
            points[i].position = at(mesh.positions) - scene_.origin;
            points[i].area =
                0.5 * stretch * cross(mesh.positions[corner.y] - a, mesh.positions[corner.z] - a);
            points[i].normal = normalize(at(mesh.normals));
        }
        return points;
    }
    const scene::Extent& extent = state.water->extent;
    const glm::dvec2 corner = extent.center - 0.5 * extent.size;
    const glm::dvec2 cell = extent.size / glm::dvec2(size.columns, size.rows);
    std::vector<double> x(count), z(count), height(count), slope_x(count), slope_z(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t stratum = begin + i;
        x[i] = corner.x + cell.x * (static_cast<double>(stratum % size.columns) +
                                    random_number(state, pass, light, stratum, kAcross));
        z[i] = corner.y + cell.y * (static_cast<double>(stratum / size.columns) +
                                    random_number(state, pass, light, stratum, kAlong));
    }
    surface_.evaluate(x, z, height, slope_x, slope_z);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 upwards(-slope_x[i], 1, -slope_z[i]);
        points[i].position = glm::dvec3(x[i], height[i], z[i]) - scene_.origin;
        points[i].area = cell.x * cell.y * upwards;
        points[i].normal = normalize(upwards);
    }
    return points;
}

std::optional<LightTracer::Incoming> LightTracer::illuminate(const LightPass& pass, const LitBy& by,
                                                             const WaterPoint& point,
                                                             std::size_t stratum) const {
    const scene::Light& light = by.light;
    Incoming incoming;
    incoming.point = point;
    glm::dvec3 across;  // W/m^2 on a plane across the light
    if (light.type == scene::LightType::sun) {
        const SunRay ray = sun_ray(light, random_number(scene_.state, pass, by.index, stratum, kDiscRadius),
                                   random_number(scene_.state, pass, by.index, stratum, kDiscAngle));
        if (!(ray.direction.y < 0)) return {};
        incoming.direction = ray.direction;
        incoming.distance = std::numeric_limits<double>::infinity();
        across = ray.irradiance * light.irradiance;
    } else {
        const glm::dvec3 way = point.position - (light.position - scene_.origin);
        incoming.distance = length(way);
        incoming.direction = way / incoming.distance;
        const double share =
            light.type == scene::LightType::spot
                ? spot_share(dot(incoming.direction, light.direction), light.cone_angle, light.falloff_angle)
                : 1;
        across = share / (incoming.distance * incoming.distance) * light.intensity;
    }
    const double facing = -dot(point.area, incoming.direction);
    incoming.side = facing > 0 ? 1 : -1;
    if (!(incoming.side > 0 ? by.from_above : by.from_below)) return {};
    incoming.power = std::abs(facing) * across;
    if (incoming.side < 0) absorb(incoming.power, incoming.distance);
    if (!finite(incoming.power) || !(mean(incoming.power) > 0)) return {};
    return incoming;
}

void LightTracer::remove_shadowed(const LitBy& by, std::vector<Incoming>& incoming) const {
    const bool sun = by.light.type == scene::LightType::sun;
    std::vector<rays::Ray> to_light;
    const auto ray_of = [&](const Incoming& light, double near) {  // towards a lamp: its distance is 1
        const glm::dvec3& origin = light.point.position;
        return sun ? float_ray(origin, -light.direction, near, std::numeric_limits<float>::infinity())
                   : float_ray(origin, by.light.position - scene_.origin - origin, near / light.distance, 1);
    };
    if (rays_.has_objects()) {
        for (const Incoming& light : incoming) to_light.push_back(ray_of(light, 0));
        std::vector<std::uint8_t> occluded(incoming.size());
        rays_.occluded_by_objects(to_light, occluded);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < incoming.size(); ++i) {
            if (occluded[i] == 0) incoming[kept++] = incoming[i];
        }
        incoming.resize(kept);
    }
    if (!by.waves_may_shadow) return;
    to_light.clear();
    std::vector<std::size_t> tested;
    for (std::size_t i = 0; i < incoming.size(); ++i) {
        if (!may_meet_water(incoming[i].direction)) continue;
        tested.push_back(i);
        to_light.push_back(
            ray_of(incoming[i], clear_of_water(incoming[i].point.position, incoming[i].direction,
                                               normalize(incoming[i].point.area))));
    }
    std::vector<rays::Hit> hits(tested.size());
    water_rays_->intersect_water(to_light, hits);
    std::vector<std::uint8_t> dark(incoming.size(), 0);
    for (std::size_t i = 0; i < tested.size(); ++i) dark[tested[i]] = hits[i].primitive != rays::kNoHit;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < incoming.size(); ++i) {
        if (dark[i] == 0) incoming[kept++] = incoming[i];
    }
    incoming.resize(kept);
}

bool LightTracer::may_meet_water(const glm::dvec3& direction) const {
    return std::abs(direction.y) <= surface_.steepest() * std::hypot(direction.x, direction.z);
}

/// A few roundings of a float position, m.
double LightTracer::size_of(const glm::dvec3& position) const {
    const glm::dvec3 size = glm::abs(position);
    return 0x1p-20 * (1 + std::max({size.x, size.y, size.z}));
}

/// Along a ray from a point of the true surface, the way after which it is clear of the triangles about it,
/// m.
double LightTracer::clear_of_water(const glm::dvec3& position, const glm::dvec3& direction,
                                   const glm::dvec3& normal) const {
    return (chord_error_ + size_of(position)) / std::max(1e-6, std::abs(dot(direction, normal)));
}

void LightTracer::absorb(glm::dvec3& power, double distance) const {
    const glm::dvec3& absorption = scene_.state.water->absorption;
    if (absorption != glm::dvec3(0)) power *= glm::exp(-distance * absorption);
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
        ray.clear = water_rays_ ? clear_of_water(position, direction, geometric) : 0;
        ray.in_water = in_water;
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
    for (int channel = 0; channel < 3; ++channel) {
        glm::dvec3 power(0);
        power[channel] = incoming.power[channel];
        add(power, water.refractive_index + 0.5 * (channel - 1) * water.dispersion);
    }
}

void LightTracer::follow(std::vector<LightRay>& rays, std::vector<Arrival>& arrivals) const {
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
        if (water_rays_) {
            tested.clear();
            std::size_t count = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (rays[i].left_water && !may_meet_water(rays[i].direction)) continue;
                traced[count] = traced[i];
                traced[count].near = static_cast<float>(rays[i].clear);
                traced[count++].far = objects[i].distance;
                tested.push_back(i);
            }
            water_hits.resize(count);
            water_rays_->intersect_water(std::span(traced).first(count), water_hits);
            for (std::size_t i = 0; i < count; ++i) water[tested[i]] = water_hits[i];
        }
        next.clear();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (water[i].primitive != rays::kNoHit)
                cross_again(rays[i], water[i], next);
            else if (objects[i].primitive != rays::kNoHit)
                arrive(rays[i], objects[i], next, arrivals);
        }
        rays.swap(next);
    }
}

void LightTracer::arrive(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next,
                         std::vector<Arrival>& arrivals) const {
    const view::SurfacePoint point = geometry_.object_point(hit, ray.position, ray.direction);
    if (ray.in_water) absorb(ray.power, point.distance);
    const scene::Material& material = scene_.state.objects[hit.object].material;
    if (!material.mirror) {
        const ChartPlace place = charts_.place(hit.object, hit.primitive, point.position, -ray.direction);
        if (place.density > 0 && finite(ray.power)) arrivals.push_back({place, ray.power});
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
    ray.lift = size_of(point.position) * geometric;
    ray.clear = 0;
    ray.power *= material.color;
    ray.left_water = false;
    ++ray.events;
    if (mean(ray.power) > ray.least_power) next.push_back(ray);
}

void LightTracer::cross_again(LightRay ray, const rays::Hit& hit, std::vector<LightRay>& next) const {
    if (!options_.second_crossings || ray.events == kMostEvents) return;
    const Crossing crossing = true_crossing(ray, hit);
    if (ray.in_water) absorb(ray.power, crossing.distance);
    ++ray.events;
    add_branches(ray, crossing.position, crossing.geometric_normal, crossing.shading_normal, true, true,
                 next);
}

/// From the triangle that was hit to the surface itself: for height fields by Newton's method along the ray.
LightTracer::Crossing LightTracer::true_crossing(const LightRay& ray, const rays::Hit& hit) const {
    const view::SurfacePoint point = water_geometry_->water_point(hit, ray.position, ray.direction);
    Crossing crossing{point.position, point.geometric_normal, point.shading_normal, point.distance};
    if (!surface_.is_height_field()) return crossing;
    double distance = point.distance;
    double height = 0, slope_x = 0, slope_z = 0;
    for (int step = 0; step < 4; ++step) {
        const glm::dvec3 at = ray.position + distance * ray.direction + scene_.origin;
        surface_.evaluate(std::span(&at.x, 1), std::span(&at.z, 1), std::span(&height, 1),
                          std::span(&slope_x, 1), std::span(&slope_z, 1));
        const double gap = at.y - height;
        const double rate = ray.direction.y - slope_x * ray.direction.x - slope_z * ray.direction.z;
        // Rays that graze the surface cross the triangles but not it: the triangle's place is as good.
        if (std::abs(rate) < 1e-6 || std::abs(gap / rate) > 1e3 * (chord_error_ + size_of(ray.position)))
            return crossing;
        distance -= gap / rate;
    }
    crossing.distance = distance;
    crossing.position = ray.position + distance * ray.direction;
    crossing.geometric_normal = crossing.shading_normal = normalize(glm::dvec3(-slope_x, 1, -slope_z));
    return crossing;
}

void LightTracer::trace(const LightPass& pass, std::size_t light, std::size_t begin, std::size_t end,
                        std::vector<Arrival>& arrivals) const {
    const LitBy& by = lights_[light];
    const std::vector<WaterPoint> points = sample_water(pass, by.index, begin, end);
    std::vector<Incoming> incoming;
    incoming.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (const auto lit = illuminate(pass, by, points[i], begin + i)) incoming.push_back(*lit);
    }
    remove_shadowed(by, incoming);
    std::vector<LightRay> rays;
    rays.reserve(2 * incoming.size());
    for (const Incoming& lit : incoming) meet_water(by, lit, rays);
    follow(rays, arrivals);
}

}  // namespace dapple::reference
