#include "methods/reference/lamp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "light/beam_mesh.h"
#include "methods/reference/own_optics.h"

namespace dapple::reference {
Lamp::Lamp(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterRays& water,
           const GlassBodies& glass, const OwnMedia& media, std::uint32_t index)
    : scene_(scene),
      rays_(rays),
      water_(water),
      glass_(glass),
      media_(media),
      light_(scene.state.lights[index]),
      samples_(scene, index, light::kWater),
      picture_(scene, index) {
    const TrueSurface& surface = water.surface();
    if (light_.part.count > 0)
        reach_ = distance(light_.position, light_.part.center) +
                 (light_.type == scene::LightType::disc ? light_.radius : 0.5 * length(light_.size));
    if (light_.type != scene::LightType::sun) {
        from_above_ = light_.position.y + reach_ > -surface.highest();
        from_below_ = light_.position.y - reach_ < surface.highest();
    }
    waves_may_shadow_ = lowest_elevation() <= std::atan(surface.steepest()) &&
                        (surface.highest() > 0 || !surface.is_height_field());
}

double Lamp::lowest_elevation() const {
    if (light_.type == scene::LightType::sun)
        return std::asin(std::clamp(-light_.direction.y, -1.0, 1.0)) - 0.5 * light_.angular_diameter;
    const scene::Extent& extent = scene_.state.water->extent;
    const glm::dvec2 place(light_.position.x, light_.position.z);
    const glm::dvec2 reach = glm::abs(place - extent.center) + 0.5 * extent.size;
    return std::atan2(std::abs(light_.position.y) - reach_ - water_.surface().highest(),
                      length(reach) + reach_);
}

double Lamp::aspect() const {
    const glm::dvec2 size = scene_.state.water->extent.size;
    return water_.surface().is_height_field() ? size.x / size.y : 0;
}

std::size_t Lamp::strata(const LightPass& pass) const {
    if (pass.layout != nullptr) return pass.layout->strata();
    return StrataGrid(pass.strata, aspect()).strata();
}

/// As many equal stretches along the numbers of the triangles as there are strata, and a random point of the
/// triangle in each.
std::vector<WaterPoint> Lamp::sample_triangles(const LightPass& pass, std::size_t begin,
                                               std::size_t end) const {
    const std::size_t count = end - begin;
    std::vector<WaterPoint> points(count);
    const StrataGrid size(pass.strata, aspect());
    const scene::TriangleMesh& mesh = water_.mesh();
    const double stretch = static_cast<double>(mesh.triangles.size()) / static_cast<double>(size.columns);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t stratum = begin + i;
        const double facet = samples_.number(pass, stratum, Dimension::facet);
        double share = stretch;  // triangles that the point stands for
        double place = stretch * (static_cast<double>(stratum) + facet);
        if (pass.layout != nullptr) {
            const StrataLayout::Cell cell = pass.layout->cell(stratum);
            const auto triangles = static_cast<double>(mesh.triangles.size());
            share = cell.width * triangles;
            place = (cell.x + cell.width * facet) * triangles;
        }
        const glm::uvec3 corner =
            mesh.triangles[std::min(mesh.triangles.size() - 1, static_cast<std::size_t>(place))];
        const double root = std::sqrt(samples_.number(pass, stratum, Dimension::along));
        const double v = root * samples_.number(pass, stratum, Dimension::across);
        const glm::dvec3 weight(1 - root, root - v, v);
        const auto at = [&](const std::vector<glm::dvec3>& values) {
            return weight.x * values[corner.x] + weight.y * values[corner.y] + weight.z * values[corner.z];
        };
        const glm::dvec3& a = mesh.positions[corner.x];
        points[i].position = at(mesh.positions) - scene_.origin;
        points[i].area = 0.5 * share * cross(mesh.positions[corner.y] - a, mesh.positions[corner.z] - a);
        points[i].normal = normalize(at(mesh.normals));
    }
    return points;
}

/// A jittered grid over the extent.
std::vector<WaterPoint> Lamp::sample_height_field(const LightPass& pass, std::size_t begin,
                                                  std::size_t end) const {
    const std::size_t count = end - begin;
    std::vector<WaterPoint> points(count);
    const StrataGrid size(pass.strata, aspect());
    const scene::Extent& extent = scene_.state.water->extent;
    const glm::dvec2 corner = extent.center - 0.5 * extent.size;
    const glm::dvec2 even = extent.size / glm::dvec2(size.columns, size.rows);
    std::vector<glm::dvec2> cells(count, even);
    std::vector<double> x(count), z(count), height(count), slope_x(count), slope_z(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t stratum = begin + i;
        glm::dvec2 low = even * glm::dvec2(stratum % size.columns, stratum / size.columns);
        if (pass.layout != nullptr) {
            const StrataLayout::Cell cell = pass.layout->cell(stratum);
            low = glm::dvec2(cell.x, cell.y) * extent.size;
            cells[i] = glm::dvec2(cell.width, cell.height) * extent.size;
        }
        x[i] = corner.x + low.x + cells[i].x * samples_.number(pass, stratum, Dimension::across);
        z[i] = corner.y + low.y + cells[i].y * samples_.number(pass, stratum, Dimension::along);
    }
    water_.surface().evaluate(x, z, height, slope_x, slope_z);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 upwards(-slope_x[i], 1, -slope_z[i]);
        points[i].position = glm::dvec3(x[i], height[i], z[i]) - scene_.origin;
        points[i].area = cells[i].x * cells[i].y * upwards;
        points[i].normal = normalize(upwards);
    }
    return points;
}

std::optional<Incoming> Lamp::illuminate(const LightPass& pass, const WaterPoint& point,
                                         std::size_t stratum) const {
    Incoming incoming;
    incoming.point = point;
    glm::dvec3 across;  // W/m^2 on a plane across the light
    if (light_.type == scene::LightType::sun) {
        const SunRay ray = sun_ray(light_, samples_.number(pass, stratum, Dimension::disc_radius),
                                   samples_.number(pass, stratum, Dimension::disc_angle));
        if (!(ray.direction.y < 0)) return {};
        incoming.direction = ray.direction;
        incoming.distance = std::numeric_limits<double>::infinity();
        across = ray.irradiance * light_.irradiance;
    } else {
        incoming.source =
            emission_point(scene_, light_, samples_.number(pass, stratum, Dimension::disc_radius),
                           samples_.number(pass, stratum, Dimension::disc_angle));
        const glm::dvec3 way = point.position - incoming.source;
        incoming.distance = length(way);
        incoming.direction = way / incoming.distance;
        across =
            intensity_towards(light_, picture_, incoming.direction) / (incoming.distance * incoming.distance);
    }
    const double facing = -dot(point.area, incoming.direction);
    incoming.side = facing > 0 ? 1 : -1;
    if (!(incoming.side > 0 ? from_above_ : from_below_)) return {};
    incoming.power = std::abs(facing) * across;
    incoming.random = samples_.ray(pass, stratum);
    incoming.stratum = static_cast<std::uint32_t>(stratum);
    if (!finite(incoming.power) || !(mean(incoming.power) > 0)) return {};
    return incoming;
}

void Lamp::remove_hidden(std::vector<Incoming>& incoming) const {
    const bool sun = light_.type == scene::LightType::sun;
    std::vector<rays::Ray> to_light;
    const auto ray_of = [&](const Incoming& light, double near) {  // towards a lamp: its distance is 1
        const glm::dvec3& origin = light.point.position;
        return sun ? float_ray(origin, -light.direction, near, std::numeric_limits<float>::infinity())
                   : float_ray(origin, light.source - origin, near / light.distance, 1);
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
    // Last of what asks objects: most points within glass are in its shadow. Lamps in it have their own
    // source.
    if (glass_.any())
        std::erase_if(incoming, [&](const Incoming& light) {
            return glass_.replace_water(light.point.position, normalize(light.point.area));
        });
    if (!waves_may_shadow_) return;
    to_light.clear();
    std::vector<std::size_t> tested;
    for (std::size_t i = 0; i < incoming.size(); ++i) {
        if (!water_.may_return(incoming[i].direction)) continue;
        tested.push_back(i);
        to_light.push_back(
            ray_of(incoming[i], water_.clear_of_water(incoming[i].point.position, incoming[i].direction,
                                                      normalize(incoming[i].point.area))));
    }
    std::vector<rays::Hit> hits(tested.size());
    water_.intersect(to_light, hits);
    std::vector<std::uint8_t> dark(incoming.size(), 0);
    for (std::size_t i = 0; i < tested.size(); ++i) dark[tested[i]] = hits[i].primitive != rays::kNoHit;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < incoming.size(); ++i) {
        if (dark[i] == 0) incoming[kept++] = incoming[i];
    }
    incoming.resize(kept);
}

/// By the media between the lamp and the water.
void Lamp::attenuate(std::vector<Incoming>& incoming, MediaProbe& probe) const {
    if (!media_.any_bounded(false) && !media_.any_bounded(true) && !from_below_) return;
    for (Incoming& light : incoming) {
        RandomStream random{scene_.state.clip.seed, static_cast<std::uint64_t>(scene_.state.frame),
                            light.random};
        light.power *= probe.transmittance(light.point.position, -light.direction, light.distance,
                                           light.side < 0, random);
    }
    std::erase_if(incoming, [](const Incoming& light) { return !(mean(light.power) > 0); });
}

std::vector<Incoming> Lamp::shine(const LightPass& pass, std::size_t begin, std::size_t end,
                                  MediaProbe& probe) const {
    const std::vector<WaterPoint> points = water_.surface().is_height_field()
                                               ? sample_height_field(pass, begin, end)
                                               : sample_triangles(pass, begin, end);
    std::vector<Incoming> incoming;
    incoming.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (const auto lit = illuminate(pass, points[i], begin + i)) incoming.push_back(*lit);
    }
    remove_hidden(incoming);
    attenuate(incoming, probe);
    return incoming;
}

}  // namespace dapple::reference
