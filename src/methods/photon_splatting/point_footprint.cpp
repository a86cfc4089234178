#include <algorithm>

#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {
namespace {

constexpr float kMostCompression = 100;  // at a focus there is no bound

}  // namespace

/// No size of its own: the kernel makes it a pixel.
Footprint point_footprint(const PhotonGrid&, const PhotonHit&) {
    return {};
}

/// Gruen 2019 as Kougianos and Moustakas 2021 describe it: hit points of the rays in pixels, and the light
/// that gathers there scaled by the compression ratio, the area between rays on the water over that where
/// they land. Where beams narrow light so counts twice, by the ratio and by the number of points; flat water
/// comes out right.
Footprint paper_point_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    Footprint footprint;
    glm::vec3 right, up;
    const bool columns = grid.step(hit, GridAxis::columns, true, right);
    const bool rows = grid.step(hit, GridAxis::rows, true, up);
    footprint.without_neighbors = !columns || !rows;
    if (footprint.without_neighbors) return footprint;
    const auto& mesh = grid.mesh();
    const auto on_water = [&](GridAxis axis) {
        const Neighbors near = grid.neighbors(hit.photon, axis);
        return grid.surface_point(near.has_after ? near.after : near.before) - grid.surface_point(hit.photon);
    };
    const float before = glm::length(glm::cross(on_water(GridAxis::columns), on_water(GridAxis::rows)));
    const float after = glm::length(glm::cross(right, up));
    footprint.gain = std::min(kMostCompression, before / std::max(after, 1e-6f * mesh.cell.x * mesh.cell.y));
    return footprint;
}

}  // namespace dapple::methods
