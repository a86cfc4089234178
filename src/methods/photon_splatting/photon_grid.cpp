#include "methods/photon_splatting/photon_grid.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods {
namespace {

// A neighbour's ray that meets the tangent plane so much more steeply or levelly spans no footprint with this
// one.
constexpr float kLeastRelativeCosine = 0.1f;
// Neighbours further apart on the water, in cells, are on different sheets of it.
constexpr float kFarthestNeighbor = 4;

}  // namespace

PhotonGrid::PhotonGrid(const scene::FrameScene& scene, const light::BeamMesh& mesh)
    : mesh_(mesh),
      columns_(static_cast<std::size_t>(mesh.columns)),
      rows_(static_cast<std::size_t>(mesh.rows)),
      farthest_(kFarthestNeighbor * std::max(mesh.cell.x, mesh.cell.y)) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
    const double n = scene.state.water->refractive_index;
    sun_ = light.type == scene::LightType::sun;
    sun_direction_ = glm::vec3(light.direction);
    light_position_ = glm::vec3(light.position - scene.origin);
    eta_ = static_cast<float>(mesh.from_below ? n : 1 / n);
}

glm::vec3 PhotonGrid::incident(std::size_t i) const {
    return sun_ ? sun_direction_ : glm::normalize(surface_point(i) - light_position_);
}

glm::vec3 PhotonGrid::normal(std::size_t i) const {
    // Snell's law and the law of reflection in vector form: what changes is along the normal.
    const glm::vec3 in = incident(i), out = glm::normalize(mesh_.slope[i]);
    const glm::vec3 turn = mesh_.event == light::Event::reflection ? out - in : out - eta_ * in;
    const glm::vec3 unit = glm::normalize(turn);
    return glm::dot(unit, in) < 0 ? unit : -unit;
}

float PhotonGrid::cell_across_light(std::size_t i) const {
    return mesh_.cell.x * mesh_.cell.y * std::abs(incident(i).y);
}

PhotonHit PhotonGrid::hit(std::size_t i, float depth, glm::vec3 normal) const {
    const glm::vec3 slope = mesh_.slope[i];
    const float steepness = glm::length(slope);
    return {i,
            depth,
            mesh_.origin[i] + depth * slope,
            normal,
            slope / steepness,
            steepness * (depth - mesh_.start[i])};
}

Neighbors PhotonGrid::neighbors(std::size_t i, GridAxis axis) const {
    const bool along_row = axis == GridAxis::columns;
    const std::size_t stride = along_row ? 1 : columns_;
    const std::size_t place = along_row ? i % columns_ : i / columns_, places = along_row ? columns_ : rows_;
    const auto same_sheet = [&](std::size_t j) {
        if (!mesh_.valid[j]) return false;
        const glm::vec3 apart = surface_point(j) - surface_point(i);
        return glm::dot(apart, apart) <= farthest_ * farthest_;
    };
    Neighbors found;
    found.before = i - stride;
    found.after = i + stride;
    found.has_before = place > 0 && same_sheet(found.before);
    found.has_after = place + 1 < places && same_sheet(found.after);
    return found;
}

bool PhotonGrid::step_to(const PhotonHit& hit, std::size_t j, glm::vec3& step) const {
    const std::size_t i = hit.photon;
    // Differences of the rays come first: the points themselves have lost the digits.
    const glm::vec3 level =
        (mesh_.origin[j] - mesh_.origin[i]) + hit.depth * (mesh_.slope[j] - mesh_.slope[i]);
    const float own = glm::dot(hit.normal, mesh_.slope[i]), other = glm::dot(hit.normal, mesh_.slope[j]);
    if (!(other < kLeastRelativeCosine * own)) return false;  // both are negative
    step = level - (glm::dot(hit.normal, level) / other) * mesh_.slope[j];
    return true;
}

glm::vec3 PhotonGrid::parallel_step(const PhotonHit& hit, GridAxis axis) const {
    const glm::vec3 across =
        axis == GridAxis::columns ? glm::vec3(mesh_.cell.x, 0, 0) : glm::vec3(0, 0, mesh_.cell.y);
    const glm::vec3 slope = mesh_.slope[hit.photon];
    return across - (glm::dot(hit.normal, across) / glm::dot(hit.normal, slope)) * slope;
}

bool PhotonGrid::step(const PhotonHit& hit, GridAxis axis, bool forward, glm::vec3& step) const {
    Neighbors near = neighbors(hit.photon, axis);
    glm::vec3 before(0), after(0);
    near.has_after = near.has_after && step_to(hit, near.after, after);
    near.has_before = near.has_before && !(forward && near.has_after) && step_to(hit, near.before, before);
    if (near.has_before && near.has_after) {
        step = 0.5f * (after - before);
    } else if (near.has_after) {
        step = after;
    } else if (near.has_before) {
        step = -before;
    } else {
        step = parallel_step(hit, axis);
    }
    return near.any();
}

}  // namespace dapple::methods
