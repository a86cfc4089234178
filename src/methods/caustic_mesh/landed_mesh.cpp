#include "methods/caustic_mesh/landed_mesh.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "light/light_shadows.h"

namespace dapple::methods::caustic_mesh {
namespace {

constexpr std::size_t kTile = 1 << 12;
// Neighbours further apart on the water, in cells, are on different sheets of it: a crest hides what lies
// between.
constexpr float kFarthestNeighbor = 4;
// A neighbour's ray that meets the plane so much more steeply or levelly spans no area with this one.
constexpr float kLeastRelativeCosine = 0.1f;

// Receivers that lean away more lie on another face: as in cell_fragment.glsl.
constexpr float kSmallestNormalCosine = 0.7f;
// Landing points farther off each other's tangent planes, against their distance, lie on different faces.
constexpr float kFaceTolerance = 0.25f;

/// Spreads marks along a line of `count` with a stride by `rings` to both sides.
void spread(std::uint8_t* marks, std::size_t count, std::size_t stride, std::size_t rings,
            std::vector<std::uint8_t>& line) {
    line.assign(count, 0);
    std::size_t until = 0;
    for (std::size_t k = 0; k < count; ++k) {
        if (marks[k * stride] == 0) continue;
        for (std::size_t j = std::max(until, k < rings ? 0 : k - rings); j < std::min(count, k + rings + 1);
             ++j)
            line[j] = 1;
        until = std::min(count, k + rings + 1);
    }
    for (std::size_t k = 0; k < count; ++k) marks[k * stride] = line[k];
}

}  // namespace

bool same_face(const MeshRay& a, const MeshRay& b) {
    if (glm::dot(a.normal, b.normal) < kSmallestNormalCosine) return false;
    const glm::vec3 step = b.landing() - a.landing();
    const float most = kFaceTolerance * glm::length(step);
    return std::abs(glm::dot(a.normal, step)) <= most && std::abs(glm::dot(b.normal, step)) <= most;
}

LandedMesh::LandedMesh(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                       const light::Landings& landings, const rays::RayScene& rays)
    : scene_(scene),
      mesh_(mesh),
      landings_(landings),
      rays_scene_(rays),
      ways_(scene, media, mesh),
      rows_(static_cast<std::size_t>(mesh.rows)),
      columns_(static_cast<std::size_t>(mesh.columns)),
      areas_(mesh.vertices(), 0),
      near_edge_(mesh.vertices(), 0),
      farthest_(kFarthestNeighbor * mesh.longest_step()) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
    const bool sun = light.type == scene::LightType::sun;
    // Light that a mirror sends on was shadowed before.
    shadowed_ = !mesh.mirrored() && light::may_shadow(scene, rays, light);
    color_ = glm::vec3(sun ? light.irradiance : light.intensity);
    // Refraction into the water narrows the disc by 1/n across the plane of incidence and by more, cos(i) /
    // (n cos(t)), in it; the wider one stands for both.
    const double narrowed =
        mesh.event == light::Event::transmission ? scene.state.water->refractive_index : 1.0;
    if (sun) disc_ = static_cast<float>(0.5 * light.angular_diameter / narrowed);
    if (disc_ > 0 && mesh.mirrored()) discs_ = mirrored_discs(mesh, disc_, farthest_);
    parallel_for(areas_.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) areas_[i] = area_about(i);
    });
    find_edges();
}

void LandedMesh::find_edges() {
    const auto differ = [&](std::size_t i, std::size_t j) {
        if (!(mesh_.flux[i] > 0 && mesh_.flux[j] > 0)) return false;
        const MeshRay a = ray(i), b = ray(j);
        return a.landed() != b.landed() || (a.landed() && !same_face(a, b));
    };
    // Rays of two tiles mark different places: a ray looks at its neighbours on all sides.
    parallel_for(near_edge_.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t column = i % columns_;
            near_edge_[i] = (column > 0 && differ(i, i - 1)) || (column + 1 < columns_ && differ(i, i + 1)) ||
                                    (i >= columns_ && differ(i, i - columns_)) ||
                                    (i + columns_ < near_edge_.size() && differ(i, i + columns_))
                                ? 1
                                : 0;
        }
    });
    parallel_for(rows_, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint8_t> line;
        for (std::size_t row = begin; row < end; ++row)
            spread(&near_edge_[row * columns_], columns_, 1, kMostRings, line);
    });
    parallel_for(columns_, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint8_t> line;
        for (std::size_t column = begin; column < end; ++column)
            spread(&near_edge_[column], rows_, columns_, kMostRings, line);
    });
}

MeshRay LandedMesh::ray(std::size_t i) const {
    MeshRay ray;
    ray.origin = mesh_.origin[i];
    ray.slope = mesh_.slope[i];
    ray.start = mesh_.start[i];
    ray.flux = mesh_.flux[i];
    if (!mesh_.tint.empty()) ray.tint = mesh_.tint[i];
    ray.depth = landings_.depth[i];
    ray.normal = landings_.normal[i];
    ray.area = areas_[i];
    ray.disc = discs_.empty() ? DiscImage{0, 0, disc_ * disc_} : discs_[i];
    return ray;
}

bool LandedMesh::connected(const MeshRay& a, const MeshRay& b) const {
    const glm::vec3 apart = a.surface_point() - b.surface_point();
    return glm::dot(apart, apart) <= farthest_ * farthest_;
}

MeshRay LandedMesh::beside(const MeshRay& ray, float columns, float rows) const {
    const glm::vec2 step = mesh_.texel * glm::vec2(columns, rows);
    const glm::vec3 across(step.x, 0, step.y);
    const float along = glm::dot(across, glm::vec3(mesh_.axis));
    MeshRay result = ray;
    result.origin += across - along * ray.slope;
    result.start += along;
    result.flux = 0;
    return result;
}

glm::vec3 LandedMesh::power(const MeshRay& ray, float depth) const {
    const float way = std::max(0.0f, depth - ray.start) * glm::length(ray.slope);
    return color_ * ray.tint * ways_.of(ray.surface_point(), ray.origin + depth * ray.slope, way);
}

void LandedMesh::land(std::span<MeshRay> rays) const {
    std::vector<rays::Ray> lines;
    for (const MeshRay& ray : rays) {
        rays::Ray line;
        line.origin = ray.surface_point();
        line.direction = ray.slope;
        lines.push_back(line);
    }
    std::vector<rays::Hit> hits(rays.size());
    rays_scene_.intersect_objects(lines, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i].depth = std::numeric_limits<float>::infinity();
        if (hits[i].primitive == rays::kNoHit) continue;
        const glm::vec3 normal = glm::normalize(hits[i].normal);
        rays[i].depth = rays[i].start + hits[i].distance;
        rays[i].normal = glm::dot(normal, rays[i].slope) < 0 ? normal : -normal;
    }
}

std::vector<std::uint8_t> LandedMesh::in_shadow(std::span<const MeshRay> rays) const {
    const scene::Light& light = scene_.state.lights[static_cast<std::size_t>(mesh_.light)];
    std::vector<rays::Ray> ways;
    for (const MeshRay& ray : rays) ways.push_back(light::ray_to_light(scene_, light, ray.surface_point()));
    std::vector<std::uint8_t> occluded(ways.size(), 0);
    rays_scene_.occluded_by_objects(ways, occluded);
    return occluded;
}

bool LandedMesh::step_to(const MeshRay& ray, std::size_t j, glm::vec3& step) const {
    if (!mesh_.valid[j]) return false;
    const glm::vec3 surface = mesh_.origin[j] + mesh_.start[j] * mesh_.slope[j];
    const glm::vec3 apart = surface - ray.surface_point();
    if (glm::dot(apart, apart) > farthest_ * farthest_) return false;
    // Differences of the rays come first: the points themselves have lost the digits.
    const glm::vec3 level = (mesh_.origin[j] - ray.origin) + ray.depth * (mesh_.slope[j] - ray.slope);
    const float own = glm::dot(ray.normal, ray.slope), other = glm::dot(ray.normal, mesh_.slope[j]);
    if (!(other < kLeastRelativeCosine * own)) return false;  // both are negative
    step = level - (glm::dot(ray.normal, level) / other) * mesh_.slope[j];
    return true;
}

/// From where ray i lands to where the next one along the grid meets the same plane: half the way between
/// both neighbours, or the way to the one there is.
bool LandedMesh::step(const MeshRay& ray, std::size_t i, std::size_t stride, bool has_before, bool has_after,
                      glm::vec3& step) const {
    glm::vec3 before(0), after(0);
    has_before = has_before && step_to(ray, i - stride, before);
    has_after = has_after && step_to(ray, i + stride, after);
    step = has_before && has_after ? 0.5f * (after - before) : has_after ? after : -before;
    return has_before || has_after;
}

float LandedMesh::area_about(std::size_t i) const {
    const MeshRay own = ray(i);
    if (!own.landed()) return 0;
    const std::size_t row = i / columns_, column = i % columns_;
    glm::vec3 along_columns, along_rows;
    if (!step(own, i, 1, column > 0, column + 1 < columns_, along_columns) ||
        !step(own, i, columns_, row > 0, row + 1 < rows_, along_rows))
        return 0;
    return std::abs(glm::dot(own.normal, glm::cross(along_columns, along_rows)));
}

}  // namespace dapple::methods::caustic_mesh
