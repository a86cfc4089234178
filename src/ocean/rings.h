#pragma once
#include <glm/glm.hpp>

#include "ocean/linear_waves.h"
#include "ocean/ring_layout.h"
#include "scene/mesh.h"

namespace dapple::ocean {

/// The surface as rings about a viewpoint (x, z): one sheet, of which every edge within the extent has two
/// triangles. Where a level's morph is 0 heights and normals are those of the waves that it has; normals
/// leave out the slope of the weight by which waves go, which is some per cent of theirs. Fills in what
/// grid_mesh does, and WaterMesh::rings.
scene::WaterMesh ring_mesh(const RingLayout& rings, const LinearWaves& waves, double choppiness, double time,
                           glm::dvec2 viewpoint);

}  // namespace dapple::ocean
