#include "light/wave_shadow.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "light/shadow_region.h"

namespace dapple::light {
namespace {

constexpr std::size_t kTile = 1 << 12;
constexpr int kSplits = 4;  // of an edge: 16 parts of a triangle

enum : std::uint8_t { kHidden, kLit, kUnknown };          // a vertex, seen from the light
enum : std::uint8_t { kNotAsked, kLeaves, kMeetsAgain };  // a ray after the event

/// m: what positions of the frame, rounded to float, may be off by, some times over.
double surface_offset(const scene::FrameScene& scene) {
    const scene::Extent& extent = scene.state.water->extent;
    const glm::dvec2 far = glm::abs(extent.center - glm::dvec2(scene.origin.x, scene.origin.z)) +
                           0.5 * extent.size + scene.water->largest_displacement;
    return 0x1p-20 * std::max({far.x, far.y, std::abs(scene.origin.y)});
}

/// A ray from a point of the water to the light.
rays::Ray shadow_ray(const scene::FrameScene& scene, const WaterLight& light, glm::dvec3 point) {
    rays::Ray ray;
    ray.origin = glm::vec3(point - scene.origin);
    if (light.type == scene::LightType::sun) {
        ray.direction = glm::vec3(-light.direction);
    } else {
        ray.direction = glm::vec3(light.position - point);
        ray.far = 1;
    }
    return ray;
}

/// State of each vertex: lit, hidden, or unknown where its normal does not face the light.
std::vector<std::uint8_t> vertex_states(const scene::FrameScene& scene, const rays::RayScene& rays,
                                        const WaterLight& light, double offset) {
    const scene::TriangleMesh& mesh = scene.water->mesh;
    const ShadowRegion region(*scene.water, light);
    std::vector<std::uint8_t> states(mesh.positions.size());
    parallel_for(states.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> ways;
        std::vector<std::size_t> vertices;
        for (std::size_t v = begin; v < end; ++v) {
            const glm::dvec3 position = mesh.positions[v], normal = light.side() * mesh.normals[v];
            const glm::dvec3 direction =
                light.type == scene::LightType::sun ? light.direction : position - light.position;
            const bool faces = glm::dot(normal, direction) < 0;
            states[v] = faces ? kLit : kUnknown;
            if (!faces || !region.holds(position)) continue;
            ways.push_back(shadow_ray(scene, light, position + offset * normal));
            vertices.push_back(v);
        }
        std::vector<rays::Hit> hits(ways.size());
        rays.intersect_water(ways, hits);
        for (std::size_t i = 0; i < hits.size(); ++i)
            if (hits[i].primitive != rays::kNoHit) states[vertices[i]] = kHidden;
    });
    return states;
}

/// Weights of the centres of the kSplits^2 equal triangles that a triangle is cut into.
std::vector<glm::dvec3> part_centers() {
    std::vector<glm::dvec3> centers;
    for (int i = 0; i < kSplits; ++i)
        for (int j = 0; i + j < kSplits; ++j) {
            const double u = (i + 1.0 / 3) / kSplits, v = (j + 1.0 / 3) / kSplits;
            centers.emplace_back(1 - u - v, u, v);
            if (i + j + 1 == kSplits) continue;
            const double across = 1.0 / (3 * kSplits);  // the part upside down beside it
            centers.emplace_back(1 - u - v - 2 * across, u + across, v + across);
        }
    return centers;
}

}  // namespace

std::vector<float> visible_shares(const scene::FrameScene& scene, const rays::RayScene& rays,
                                  const WaterLight& light) {
    const scene::TriangleMesh& mesh = scene.water->mesh;
    const double offset = surface_offset(scene);
    const std::vector<std::uint8_t> states = vertex_states(scene, rays, light, offset);
    const std::vector<glm::dvec3> centers = part_centers();
    std::vector<float> visible(mesh.triangles.size(), 1.0f);
    parallel_for(visible.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> ways;
        std::vector<std::size_t> sampled;
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3 t = mesh.triangles[i];
            const int first = states[t.x];
            const bool same = states[t.y] == first && states[t.z] == first;
            if (same && first == kLit) continue;
            if (!(incident_on_triangle(mesh, t, light) > 0)) continue;
            if (same && first == kHidden) {
                visible[i] = 0;
                continue;
            }
            const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
            const glm::dvec3 lift = offset * light.side() * glm::normalize(glm::cross(b - a, c - a));
            for (const glm::dvec3 w : centers)
                ways.push_back(shadow_ray(scene, light, w.x * a + w.y * b + w.z * c + lift));
            sampled.push_back(i);
        }
        std::vector<rays::Hit> hits(ways.size());
        rays.intersect_water(ways, hits);
        for (std::size_t k = 0; k < sampled.size(); ++k) {
            const auto from = hits.begin() + static_cast<std::ptrdiff_t>(k * centers.size());
            const auto lit =
                std::count_if(from, from + static_cast<std::ptrdiff_t>(centers.size()),
                              [](const rays::Hit& hit) { return hit.primitive == rays::kNoHit; });
            visible[sampled[k]] = static_cast<float>(lit) / static_cast<float>(centers.size());
        }
    });
    return visible;
}

template <class Real>
double second_crossing(const scene::FrameScene& scene, const rays::RayScene& rays, const WaterLight& light,
                       const BeamSheet<Real>& sheet, const SteepnessMap& steepness,
                       std::vector<std::uint8_t>& crossings) {
    const scene::TriangleMesh& mesh = scene.water->mesh;
    const double offset = surface_offset(scene);
    const double side = (sheet.event == Event::reflection ? 1 : -1) * light.side();
    crossings.resize(sheet.rays.size(), kNotAsked);
    parallel_for(crossings.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> ways;
        std::vector<std::size_t> vertices;
        for (std::size_t v = begin; v < end; ++v) {
            if (!sheet.valid[v] || crossings[v] != kNotAsked) continue;
            crossings[v] = kLeaves;
            const glm::dvec3 way =
                sheet.world_from_mesh * glm::dvec3(sheet.rays[v].slope_a, sheet.rays[v].slope_b, 1);
            if (!steepness.may_meet(mesh.positions[v], way, sheet.in_water())) continue;
            rays::Ray ray;
            ray.origin = glm::vec3(mesh.positions[v] + offset * side * mesh.normals[v] - scene.origin);
            ray.direction = glm::vec3(way);
            ways.push_back(ray);
            vertices.push_back(v);
        }
        std::vector<rays::Hit> hits(ways.size());
        rays.intersect_water(ways, hits);
        for (std::size_t i = 0; i < hits.size(); ++i)
            if (hits[i].primitive != rays::kNoHit) crossings[vertices[i]] = kMeetsAgain;
    });
    std::vector<double> tiles(mesh.triangles.size() / kTile + 1, 0);
    parallel_for(mesh.triangles.size(), kTile, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const glm::uvec3 t = mesh.triangles[i];
            const int met = (crossings[t.x] == kMeetsAgain) + (crossings[t.y] == kMeetsAgain) +
                            (crossings[t.z] == kMeetsAgain);
            sum += static_cast<double>(sheet.flux[i]) * met / 3;
        }
        tiles[begin / kTile] = sum;
    });
    return std::accumulate(tiles.begin(), tiles.end(), 0.0);
}

template double second_crossing(const scene::FrameScene&, const rays::RayScene&, const WaterLight&,
                                const BeamSheet<float>&, const SteepnessMap&, std::vector<std::uint8_t>&);
template double second_crossing(const scene::FrameScene&, const rays::RayScene&, const WaterLight&,
                                const BeamSheet<double>&, const SteepnessMap&, std::vector<std::uint8_t>&);

}  // namespace dapple::light
