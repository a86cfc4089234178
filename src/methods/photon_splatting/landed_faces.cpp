#include "methods/photon_splatting/landed_faces.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dapple::methods {
namespace {

// A ray that meets a neighbour's plane so much more steeply or levelly than that one does not light it.
constexpr float kLeastRelativeCosine = 0.1f;
// As in splat_fragment.glsl.
constexpr float kSmallestNormalCosine = 0.7f;
// Steps between neighbours by which a plane may lie behind what a ray hit and still form a corner with it.
constexpr float kCornerReach = 2;

/// Whether a splat of one lights receivers about the other: what the fragment shader asks of a receiver.
bool same_face(const light::BeamMesh& mesh, const light::Landings& landings, std::size_t j, std::size_t k) {
    if (j == k) return true;
    if (glm::dot(landings.normal[j], landings.normal[k]) < kSmallestNormalCosine) return false;
    const auto point = [&](std::size_t i) { return mesh.origin[i] + landings.depth[i] * mesh.slope[i]; };
    const glm::vec3 step = point(k) - point(j);
    const float off = glm::dot(landings.normal[j], step);
    return off * off <= kPlaneTolerance * kPlaneTolerance * glm::dot(step, step);
}

/// Depth at which ray i meets the plane that its neighbour j landed on. False where i was stopped well
/// before: there it lies in shadow. A plane shortly behind what i hit is the other side of a concave corner.
bool reaches(const light::BeamMesh& mesh, const light::Landings& landings, std::size_t i, std::size_t j,
             float& depth) {
    const glm::vec3 normal = landings.normal[j];
    const float own = glm::dot(normal, mesh.slope[i]), other = glm::dot(normal, mesh.slope[j]);
    if (!(own < kLeastRelativeCosine * other)) return false;  // both are negative
    const glm::vec3 level =
        (mesh.origin[i] - mesh.origin[j]) + landings.depth[j] * (mesh.slope[i] - mesh.slope[j]);
    depth = landings.depth[j] - glm::dot(normal, level) / own;
    if (depth < mesh.start[i]) return false;
    const float behind = (depth - landings.depth[i]) * glm::length(mesh.slope[i]);
    return !(behind > kCornerReach * glm::length(level));
}

}  // namespace

Flags on_one_face(const Photons& photons, const PhotonHits& hits, const light::Landings& landings,
                  std::size_t columns) {
    Flags even = finite(hits.depth);
    const std::size_t first = photons.vertex[0];
    const std::array<std::size_t, 4> from = {first - 1, first + 1, first - columns, first + columns};
    for (std::size_t side = 0; side < 4; ++side) {
        const Photons::Beside& beside = photons.beside[side];
        const Floats depth = load(&landings.depth[from[side]]);
        const Vectors3 normal = load(&landings.normal[from[side]]);
        // As in same_face.
        const Vectors3 step = hits.point - (beside.ray.origin + depth * beside.ray.slope);
        const Floats off = dot(normal, step);
        const Flags same = (dot(normal, hits.normal) >= kSmallestNormalCosine) &
                           (off * off <= kPlaneTolerance * kPlaneTolerance * dot(step, step));
        even &= ~beside.present | ~finite(depth) | same;
    }
    return even;
}

LandedFaces landed_faces(const light::BeamMesh& mesh, const light::Landings& landings, std::size_t i,
                         bool neighbors) {
    LandedFaces result;
    std::array<std::size_t, 5> of{};  // the photon that landed on each
    const auto add = [&](std::size_t j, float depth) {
        of[result.count] = j;
        result.faces[result.count++] = {depth, landings.normal[j]};
    };
    if (std::isfinite(landings.depth[i])) add(i, landings.depth[i]);
    if (!neighbors) return result;
    const std::size_t columns = static_cast<std::size_t>(mesh.columns),
                      rows = static_cast<std::size_t>(mesh.rows);
    const std::size_t row = i / columns, column = i % columns;
    const std::array<std::pair<bool, std::size_t>, 4> beside = {{{column > 0, i - 1},
                                                                 {column + 1 < columns, i + 1},
                                                                 {row > 0, i - columns},
                                                                 {row + 1 < rows, i + columns}}};
    for (const auto& [present, j] : beside) {
        if (!present || !std::isfinite(landings.depth[j])) continue;
        const bool known =
            std::any_of(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(result.count),
                        [&, face = j](std::size_t k) { return same_face(mesh, landings, face, k); });
        float depth;
        if (!known && reaches(mesh, landings, i, j, depth)) add(j, depth);
    }
    return result;
}

}  // namespace dapple::methods
