#pragma once
#include "scene/mesh.h"

/// The triangles of the shapes that have no file, so that a Hit's primitive and barycentric mean the same to
/// the tracer and to those who read its hits.
namespace dapple::rays {

/// size.x by size.z at y = 0, facing +y: triangles 0 and 1.
scene::TriangleMesh plane_mesh(const glm::dvec3& size);

/// Centred; triangles 2 f and 2 f + 1 make face f of +x, -x, +y, -y, +z, -z.
scene::TriangleMesh box_mesh(const glm::dvec3& size);

}  // namespace dapple::rays
