#include "methods/sliced_beams/point_paths.h"

#include <algorithm>
#include <cmath>

#include "methods/sliced_beams/point_query.h"

namespace dapple::methods::sliced_beams {
namespace {

Receiver<double> point_receiver(const glm::dvec3& position, const glm::dvec3& normal) {
    const glm::dvec3 helper = std::abs(normal.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(helper, normal));
    return {position, u, glm::cross(normal, u), normal};
}

class PathFinder {
public:
    PathFinder(const scene::FrameScene& scene, const rays::RayScene& rays, const glm::dvec3& normal)
        : scene_(scene), rays_(rays), normal_(normal) {}

    void find(const SheetCoverage<double>& sheet, const BeamNeighbors& neighbors,
              const Receiver<double>& point, PointPaths& found) const {
        bool fold = false;
        for (const PointHit<double>& hit : PointQuery<double>(sheet, neighbors).hits(point, fold)) {
            found.paths.push_back(describe(sheet, point, hit));
            ++found.count;
            found.sign_sum += hit.sign;
        }
        found.fold |= fold;
    }

private:
    PointPath describe(const SheetCoverage<double>& sheet, const Receiver<double>& point,
                       const PointHit<double>& hit) const {
        const light::BeamSheet<double>& beams = sheet.sheet();
        const Receiver<double> local = sheet.rotated(point);
        const glm::uvec3& triangle = sheet.triangles()[hit.beam];
        glm::dvec3 water(0), slope(0), landed[3];
        glm::dvec2 at_start[3], at_point[3];
        for (int k = 0; k < 3; ++k) {
            const auto& ray = beams.rays[triangle[k]];
            const double start = beams.start[triangle[k]];
            const auto at = [&](double depth) {
                return glm::dvec3(ray.a + depth * ray.slope_a, ray.b + depth * ray.slope_b, depth);
            };
            const glm::dvec3 along(ray.slope_a, ray.slope_b, 1);
            const double depth =
                glm::dot(local.normal, local.position - at(0)) / glm::dot(local.normal, along);
            water += hit.weights[k] * at(start);
            slope += hit.weights[k] * along;
            landed[k] = at(depth);
            at_start[k] = glm::dvec2(at(start));
            at_point[k] = glm::dvec2(at(local.position.z));
        }
        const auto area = [](const glm::dvec2(&corner)[3]) {
            const glm::dvec2 p = corner[1] - corner[0], q = corner[2] - corner[0];
            return p.x * q.y - p.y * q.x;
        };
        PointPath path;
        path.chain = beams.name;
        path.light = beams.light;
        path.water_point = beams.world_from_mesh * water + scene_.origin;
        path.direction = glm::normalize(beams.world_from_mesh * slope);
        path.way = glm::length(local.position - water);
        const double landed_area =
            0.5 * glm::length(glm::cross(landed[1] - landed[0], landed[2] - landed[0]));
        path.irradiance = beams.power(hit.beam) / landed_area * glm::exp(-path.way * sheet.extinction());
        path.jacobian = area(at_point) / area(at_start);
        path.sign = hit.sign;
        path.near_fold = hit.near_fold;
        path.triangle = hit.beam;
        find_blocker(sheet, point.position, path);
        return path;
    }

    void find_blocker(const SheetCoverage<double>& sheet, const glm::dvec3& point, PointPath& path) const {
        const glm::dvec3 water = path.water_point - scene_.origin;
        const glm::dvec3 from = point + std::max(1e-6, 4e-7 * glm::length(point)) * normal_;
        rays::Ray way[2] = {{glm::vec3(from), 0, glm::vec3(water - from), 1}, {glm::vec3(water), 0, {}}};
        const bool sun = sheet.sheet().light_direction != glm::dvec3(0);
        const scene::Light& light = scene_.state.lights[static_cast<std::size_t>(sheet.sheet().light)];
        way[1].direction =
            glm::vec3(sun ? -sheet.sheet().light_direction : light.position - path.water_point);
        if (!sun) way[1].far = 1;
        rays::Hit hits[2];
        rays_.intersect_objects(way, hits);
        for (int side = 0; side < 2 && !path.blocker; ++side) {
            if (hits[side].object == rays::kNoHit) continue;
            path.blocker = hits[side].object;
            path.blocked_in_air = side == 1;
        }
    }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    glm::dvec3 normal_;
};

}  // namespace

PointPaths find_point_paths(const scene::FrameScene& scene, const rays::RayScene& rays,
                            std::span<const light::Chain> chains, const glm::dvec3& world_point,
                            const glm::dvec3& normal, bool in_water) {
    PointPaths found;
    if (!scene.water) return found;
    const BeamNeighbors neighbors(scene.water->rows, scene.water->columns, scene.water->mesh.triangles);
    const Receiver<double> point = point_receiver(world_point - scene.origin, normal);
    const PathFinder finder(scene, rays, normal);
    FrameStats stats;
    for (const light::Chain& chain : chains) {
        for (light::BeamSheet<double>& sheet : light::water_beams<double>(scene, rays, chain, 1, stats)) {
            if (sheet.in_water() != in_water || !sheet.counts_paths) continue;
            const double depth = glm::dot(sheet.world_from_mesh[2], point.position);
            const SheetCoverage<double> coverage(scene, rays, std::move(sheet),
                                                 depth + 1e-3 * (1 + std::abs(depth)));
            finder.find(coverage, neighbors, point, found);
        }
    }
    return found;
}

}  // namespace dapple::methods::sliced_beams
