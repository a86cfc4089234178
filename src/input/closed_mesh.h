#pragma once
#include <string>

#include "scene/mesh.h"

namespace dapple::input {

/// Of a mesh that is to enclose a body, as glass: every edge has a triangle on either side that runs along it
/// the other way, and the triangles face outwards. Vertices in one place count as one. Throws
/// Error(input_unreadable) that names `path` and an edge.
void require_closed(const scene::TriangleMesh& mesh, const std::string& path);

}  // namespace dapple::input
