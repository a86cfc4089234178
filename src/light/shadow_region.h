#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "light/beam_flux.h"
#include "scene/mesh.h"

namespace dapple::light {

/// Where waves can hide anything from the light. Seen from the light, one connected sheet covers every point
/// of its outline once more by triangles that face it than by triangles that face away, so where more than
/// one triangle lies behind another, one of them faces away. So only points that project among triangles
/// that face away can be hidden or hide. These are kept as marked cells of the light's projection: for a sun
/// onto the rest plane, for a lamp the arc tangents of the slopes of the way from it, which keep boxes boxes.
/// A mesh that is neither a grid nor said to be one sheet may be several, which hide each other though all
/// face the light: any of its points may be hidden.
class ShadowRegion {
public:
    ShadowRegion(const scene::WaterMesh& water, const WaterLight& light);

    /// Whether the point may be hidden; false negatives only within round-off of the region's edge.
    bool holds(glm::dvec3 point) const;

private:
    /// NaN where the light has no such projection.
    glm::dvec2 project(glm::dvec3 point) const;
    glm::ivec2 cell(glm::dvec2 at) const;
    void mark(glm::dvec2 lower, glm::dvec2 upper);

    WaterLight light_;
    bool everywhere_ = false;  ///< the mesh is no grid, or some triangle could not be projected
    glm::dvec2 lower_{0, 0};
    glm::dvec2 upper_{0, 0};
    glm::dvec2 cells_per_unit_{0, 0};
    std::vector<std::uint8_t> marks_;
};

}  // namespace dapple::light
