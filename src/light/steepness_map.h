#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "scene/mesh.h"

namespace dapple::light {

/// How steep the water is where: which rays that leave it can meet it again at all. A ray in the air that
/// rises meets only triangles that are steeper than the ray or overhang, one in the water that falls too, and
/// only while it is between the lowest and the highest point of the water.
class SteepnessMap {
public:
    /// Of a mesh with at least one finite vertex.
    explicit SteepnessMap(const scene::TriangleMesh& mesh);

    /// Whether a ray from the water at `point` may meet it again. `in_water`: it travels there.
    bool may_meet(glm::dvec3 point, glm::dvec3 way, bool in_water) const;

private:
    glm::ivec2 cell(glm::dvec2 at) const;
    /// Largest values within `reach` cells of each.
    std::vector<float> widened(const std::vector<float>& values, int reach) const;

    glm::dvec3 lower_;  ///< of the finite vertices
    glm::dvec3 upper_;
    glm::dvec2 cell_size_{1, 1};
    std::vector<float> near_;  ///< squared slopes within kNear cells
    std::vector<float> far_;   ///< within kFar
    float steepest_ = 0;       ///< anywhere
};

/// Squared slope of a triangle by any normal of it; infinite where it overhangs, 0 where it has no area.
double slope_squared(glm::dvec3 normal);

}  // namespace dapple::light
