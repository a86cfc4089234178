#include "methods/reference/glass_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "methods/reference/own_optics.h"
#include "methods/reference/random_stream.h"

namespace dapple::reference {
namespace {

/// A lamp's view of a body is a rectangle where the body is farther away than this many of its radii.
constexpr double kNearest = 1.2;

}  // namespace

GlassLight::GlassLight(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterRays& water,
                       const GlassBodies& bodies, std::uint32_t light, std::uint32_t object)
    : scene_(scene),
      rays_(rays),
      water_(water),
      bodies_(bodies),
      light_(scene.state.lights[light]),
      object_(object),
      samples_(scene, light, static_cast<int>(object)),
      picture_(scene, light),
      sun_(light_.type == scene::LightType::sun) {
    const glm::dvec3 middle = bodies.middle(object);
    if (sun_) {
        axis_ = light_.direction;
        const AcrossAxis across(axis_);
        u_ = across.u;
        v_ = across.v;
        view_ = bodies.across(object, middle, u_, v_);
        const double wider = bodies.radius(object) * std::tan(0.5 * light_.angular_diameter);
        view_.low -= wider;
        view_.high += wider;
        return;
    }
    const glm::dvec3 position = light_.position - scene.origin;
    lamp_in_water_ = water.in_water(position);
    const glm::dvec3 way = middle - position;
    // Nor is there one view for all points of an area light.
    all_around_ = !(length(way) > kNearest * bodies.radius(object)) || light_.part.count > 0;
    view_ = {{0, 0}, {1, 1}};
    if (all_around_) return;
    axis_ = normalize(way);
    const AcrossAxis across(axis_);
    u_ = across.u;
    v_ = across.v;
    view_ = bodies.in_perspective(object, position, u_, v_, axis_);
}

double GlassLight::aspect() const {
    const glm::dvec2 size = view_.size();
    return size.x > 0 && size.y > 0 ? size.x / size.y : 1;
}

std::size_t GlassLight::strata(const LightPass& pass) const {
    return pass.layout != nullptr ? pass.layout->strata() : StrataGrid(pass.strata, aspect()).strata();
}

/// From a point before the body; `area` is that of the stratum.
GlassLight::Aimed GlassLight::from_sun(const glm::dvec2& place, double area, const SunRay& ray) const {
    const glm::dvec3 off = place.x * u_ + place.y * v_;
    const double back = length(off) + 1.01 * bodies_.radius(object_);
    return {bodies_.middle(object_) + off - back * ray.direction, ray.direction,
            area * dot(ray.direction, axis_) * ray.irradiance * light_.irradiance};
}

GlassLight::Aimed GlassLight::from_lamp(const glm::dvec2& place, double area,
                                        const glm::dvec3& source) const {
    Aimed aimed{source, {}, {}};
    double solid_angle;
    if (all_around_) {
        const double height = 2 * place.y - 1, angle = 2 * std::numbers::pi * place.x;
        const double level = std::sqrt(std::max(0.0, 1 - height * height));
        aimed.direction = {level * std::cos(angle), height, level * std::sin(angle)};
        solid_angle = 4 * std::numbers::pi * area;
    } else {
        const glm::dvec3 way = axis_ + place.x * u_ + place.y * v_;
        const double distance = length(way);
        aimed.direction = way / distance;
        solid_angle = area / (distance * distance * distance);
    }
    aimed.power = solid_angle * intensity_towards(light_, picture_, aimed.direction);
    return aimed;
}

std::vector<GlassIncoming> GlassLight::shine(const LightPass& pass, std::size_t begin, std::size_t end,
                                             MediaProbe& probe) const {
    const StrataGrid grid(pass.strata, aspect());
    const glm::dvec2 size = view_.size();
    std::vector<Aimed> aimed;
    std::vector<std::size_t> stratum_of;
    std::vector<rays::Ray> traced;
    for (std::size_t stratum = begin; stratum < end; ++stratum) {
        const glm::dvec2 even = 1.0 / glm::dvec2(grid.columns, grid.rows);
        const std::size_t row = stratum / grid.columns;
        StrataLayout::Cell cell{even.x * static_cast<double>(stratum - row * grid.columns),
                                even.y * static_cast<double>(row), even.x, even.y};
        if (pass.layout != nullptr) cell = pass.layout->cell(stratum);
        const auto random = [&](Dimension dimension) { return samples_.number(pass, stratum, dimension); };
        const glm::dvec2 place =
            view_.low + size * glm::dvec2(cell.x + cell.width * random(Dimension::across),
                                          cell.y + cell.height * random(Dimension::along));
        const double area = size.x * size.y * cell.width * cell.height;
        const Aimed ray =
            sun_ ? from_sun(place, area,
                            sun_ray(light_, random(Dimension::disc_radius), random(Dimension::disc_angle)))
                 : from_lamp(place, area,
                             emission_point(scene_, light_, random(Dimension::disc_radius),
                                            random(Dimension::disc_angle)));
        // As at the water, light of a sun's disc from below the horizon is left out.
        if (!finite(ray.power) || !(mean(ray.power) > 0) || (sun_ && !(ray.direction.y < 0))) continue;
        aimed.push_back(ray);
        stratum_of.push_back(stratum);
        traced.push_back(float_ray(ray.origin, ray.direction, 0, std::numeric_limits<float>::infinity()));
    }
    std::vector<rays::Hit> hits(traced.size());
    rays_.intersect_objects(traced, hits);
    std::vector<GlassIncoming> incoming;
    for (std::size_t i = 0; i < aimed.size(); ++i) {
        if (hits[i].primitive == rays::kNoHit || hits[i].object != object_) continue;
        GlassIncoming lit;
        lit.direction = aimed[i].direction;
        lit.inside = dot(aimed[i].direction, glm::dvec3(hits[i].normal)) > 0;
        lit.point = bodies_.point(hits[i], aimed[i].origin, aimed[i].direction, lit.inside);
        lit.power = aimed[i].power;
        lit.in_water = lamp_in_water_;
        lit.distance = sun_ ? std::numeric_limits<double>::infinity() : lit.point.distance;
        lit.random = samples_.ray(pass, stratum_of[i]);
        lit.stratum = static_cast<std::uint32_t>(stratum_of[i]);
        incoming.push_back(lit);
    }
    remove_hidden(incoming);
    for (GlassIncoming& lit : incoming) {
        RandomStream random{scene_.state.clip.seed, static_cast<std::uint64_t>(scene_.state.frame),
                            lit.random};
        lit.power *= lit.inside ? bodies_.through(object_, lit.distance)
                                : probe.transmittance(lit.point.position, -lit.direction, lit.distance,
                                                      lit.in_water, random);
    }
    std::erase_if(incoming, [](const GlassIncoming& lit) { return !(mean(lit.power) > 0); });
    return incoming;
}

void GlassLight::remove_hidden(std::vector<GlassIncoming>& incoming) const {
    // No light crosses the rest plane of open water outside the rectangle.
    std::erase_if(incoming, [&](const GlassIncoming& lit) {
        const glm::dvec3 position =
            lit.point.position - face_margin(lit.point.position) * lit.direction;  // before the face
        return !lit.inside && water_.beyond_rectangle(position) &&
               water_.in_water(position) != lamp_in_water_;
    });
    const auto to_light = [&](const GlassIncoming& lit) {
        // From before the body: the way to there has been traced.
        const glm::dvec3 origin = lit.point.position - std::max(0.0, lit.point.distance) * lit.direction;
        return float_ray(origin, -lit.direction, 0, std::numeric_limits<float>::infinity());
    };
    const auto keep = [&](const auto& hidden) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < incoming.size(); ++i)
            if (!hidden(i)) incoming[kept++] = incoming[i];
        incoming.resize(kept);
    };
    std::vector<rays::Ray> traced;
    if (sun_) {
        for (const GlassIncoming& lit : incoming) traced.push_back(to_light(lit));
        std::vector<std::uint8_t> occluded(traced.size());
        rays_.occluded_by_objects(traced, occluded);
        keep([&](std::size_t i) { return occluded[i] != 0; });
    }
    if (!water_.built()) return;
    traced.clear();
    for (const GlassIncoming& lit : incoming) {
        const float far = lit.inside ? 0 : static_cast<float>(lit.distance);
        const double near = face_margin(lit.point.position);
        traced.push_back(float_ray(lit.point.position, -lit.direction, near, far));
    }
    std::vector<rays::Hit> hits(traced.size());
    water_.intersect(traced, hits);
    keep([&](std::size_t i) { return !incoming[i].inside && hits[i].primitive != rays::kNoHit; });
}

}  // namespace dapple::reference
