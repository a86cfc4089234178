#include "methods/reference/oracle.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "methods/reference/oracle_search.h"

namespace dapple::oracle {
namespace {

/// Fresnel's equations for unpolarised light from the air (Born & Wolf, Principles of Optics, 1.5.3), each
/// share in the form that loses no digits.
struct Shares {
    double transmitted, reflected;
};
Shares fresnel(double cos_i, double eta) {
    const double cos_t = std::sqrt((1 - eta) * (1 + eta) + eta * eta * cos_i * cos_i);
    const double s = eta * cos_i + cos_t, p = cos_i + eta * cos_t;
    const double r_s = (eta * cos_i - cos_t) / s, r_p = (cos_i - eta * cos_t) / p;
    return {2 * eta * cos_i * cos_t * (1 / (s * s) + 1 / (p * p)), 0.5 * (r_s * r_s + r_p * r_p)};
}

/// Intensity under an angle to the light's axis over that on the axis: of a spot 1 in its inner cone, 0
/// outside the outer one, a cubic of the cosine with level ends between them; of a part of an area light the
/// cosine, on the side that shines.
double intensity_share(const scene::Light& light, double cosine) {
    if (light.type == scene::LightType::point) return 1;
    if (light.type != scene::LightType::spot) return std::max(0.0, cosine);
    const double outer = std::cos(light.cone_angle), inner = std::cos(light.cone_angle - light.falloff_angle);
    if (cosine <= outer) return 0;
    if (cosine >= inner) return 1;
    const double x = (cosine - outer) / (inner - outer);
    return x * x * (3 - 2 * x);
}

}  // namespace

double Result::irradiance() const {
    double sum = 0;
    for (const Path& path : paths) {
        if (!path.blocked) sum += path.irradiance;
    }
    return sum;
}

int Result::sign() const {
    int sum = 0;
    for (const Path& path : paths) sum += path.sign;
    return sum;
}

Oracle::Oracle(const scene::Water& water, const scene::Light& light, double time, Event event)
    : surface_(water, time),
      light_(light),
      extent_(water.extent),
      refractive_index_(water.refractive_index),
      event_(event) {
    if (light.type == scene::LightType::sun) return;
    const Surface::Local below_lamp(surface_, {light.position.x, light.position.z});
    if (light.position.y <= below_lamp.at(0, 0).height)
        throw Error(ExitCode::failure,
                    "light '" + light.name + "' is under water: paths are proven for lights above it");
}

MapConstants Oracle::constants(const glm::dvec2& anchor, double plane) const {
    const bool sun = light_.type == scene::LightType::sun;
    const glm::dvec3 relative = light_.position - glm::dvec3(anchor.x, 0, anchor.y);
    return {event_, sun, sun ? light_.direction : relative, 1 / refractive_index_, plane};
}

LandingPoint Oracle::land_local(const Surface::Local& surface, const MapConstants& map,
                                const glm::dvec2& anchor, const glm::dvec2& uv) const {
    using D = Dual<double>;
    const Jet<double> jet = surface.at(uv.x, uv.y);
    const D u = {uv.x, 1, 0}, v = {uv.y, 0, 1};
    const auto ray =
        departure<D>(map, u, v, {jet.height, jet.x, jet.z}, {jet.x, jet.xx, jet.xz}, {jet.z, jet.xz, jet.zz});
    const Landing<D> image = landing(ray, u, v);

    LandingPoint point;
    point.water_point = {anchor.x + uv.x, jet.height, anchor.y + uv.y};
    point.position = anchor + glm::dvec2(image.x.value, image.z.value);
    point.jacobian = glm::dmat2(image.x.du, image.z.du, image.x.dv, image.z.dv);
    const double side = event_ == Event::transmission ? -1 : 1;
    point.direction =
        glm::normalize(glm::dvec3(ray.ahead_x.value, side * ray.ahead_y.value, ray.ahead_z.value));

    const double facing = ray.facing.value;
    point.lands = facing > 0 && ray.drop.value > 0 && ray.ahead_y.value > 0;
    if (facing <= 0) return point;
    const glm::dvec3 way =
        map.sun ? map.light : glm::dvec3(uv.x - map.light.x, jet.height - map.light.y, uv.y - map.light.z);
    const double distance = glm::length(way);
    const double length = std::sqrt(1 + jet.x * jet.x + jet.z * jet.z);
    const Shares shares = fresnel(std::min(1.0, facing / (distance * length)), map.eta);
    point.transmittance = event_ == Event::transmission ? shares.transmitted : shares.reflected;
    double density = 1;  // W/m^2 across the ray
    if (!map.sun) {
        point.sent = intensity_share(light_, glm::dot(way, light_.direction) / distance);
        density = point.sent / (distance * distance);
    }
    point.flux = density * facing / distance * point.transmittance;
    return point;
}

LandingPoint Oracle::land(const glm::dvec2& uv, double plane) const {
    return land_local(Surface::Local(surface_, uv), constants(uv, plane), uv, {0, 0});
}

Sight Oracle::sight_of_light(const Surface::Local& surface, const MapConstants& map, const glm::dvec2& anchor,
                             const glm::dvec3& start) const {
    // Above all waves, past the water's edge or at the lamp nothing can be in the way any more.
    const glm::dvec2 from(start.x + anchor.x, start.z + anchor.y);
    glm::dvec3 back = -map.light;
    double length = INFINITY;
    if (!map.sun) {
        back = map.light - start;
        length = glm::length(back);
        back /= length;
    }
    for (const int axis : {0, 1}) {
        const double along = axis == 0 ? back.x : back.z;
        const double edge = extent_.center[axis] + std::copysign(0.5 * extent_.size[axis], along);
        if (along != 0) length = std::min(length, std::max(0.0, (edge - from[axis]) / along));
    }
    if (back.y > 0) length = std::min(length, std::max(0.0, surface_.height_bound() - start.y) / back.y);
    return surface.sight(start, back, length, true);
}

Path Oracle::path(const Surface::Local& surface, const MapConstants& map, const glm::dvec3& point,
                  const glm::dvec3& normal, const glm::dvec2& root, bool& decided) const {
    const glm::dvec2 anchor(point.x, point.z);
    const LandingPoint ray = land_local(surface, map, anchor, root);
    Path path;
    path.water_point = ray.water_point;
    path.direction = ray.direction;
    path.jacobian = glm::determinant(ray.jacobian);
    path.transmittance = ray.transmittance;
    const glm::dvec3 start(root.x, ray.water_point.y, root.y);
    const glm::dvec3 onwards = glm::dvec3(0, point.y, 0) - start;
    const double way = glm::length(onwards);
    path.way = event_ == Event::transmission ? way : 0;
    path.sent = ray.sent;
    // Flux through the level plane, turned to the receiver.
    const double tilt = std::max(0.0, -glm::dot(ray.direction, normal)) / std::abs(ray.direction.y);
    path.irradiance = ray.flux * tilt / std::abs(path.jacobian);
    for (const Sight sight : {sight_of_light(surface, map, anchor, start),
                              surface.sight(start, onwards / way, way, event_ == Event::reflection)}) {
        decided = decided && sight != Sight::undecided;
        path.blocked = path.blocked || sight != Sight::clear;
    }
    return path;
}

Result Oracle::paths(const glm::dvec3& point, const glm::dvec3& normal) const {
    Result result;
    if (light_.type == scene::LightType::sun && light_.direction.y >= 0) return result;  // it has set
    const glm::dvec2 anchor(point.x, point.z);
    const Surface::Local surface(surface_, anchor);
    const MapConstants map = constants(anchor, point.y);
    const glm::dvec2 low = extent_.center - 0.5 * extent_.size - anchor;
    const glm::dvec2 high = extent_.center + 0.5 * extent_.size - anchor;
    const RootSearch search = find_roots(surface, map, {{low.x, high.x}, {low.y, high.y}});
    result.boxes = search.boxes;
    for (const Root& root : search.roots) {
        result.paths.push_back(path(surface, map, point, normal, center(root.enclosure), result.proven));
        result.paths.back().sign = root.sign;
    }
    for (const Box& box : search.undecided) {
        result.proven = false;
        result.undecided.push_back({anchor + center(box), 0.5 * glm::dvec2(width(box.x), width(box.z))});
    }
    return result;
}

}  // namespace dapple::oracle
