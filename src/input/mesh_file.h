#pragma once
#include <string>
#include <string_view>

#include "scene/mesh.h"

namespace dapple::input {

/// Triangles of a PLY (ASCII, binary of both byte orders) or OBJ file, told apart by the ending of the name.
/// Faces of more than three vertices become fans about their first vertex; normals (made unit) and texture
/// coordinates are kept where every vertex has them; the file's own axes and unit. Every count is checked
/// against the size of the file before memory is taken. Error(input_unreadable), one line with the file and
/// what is wrong in it: missing, truncated, counts that the file cannot hold, indices out of range, numbers
/// that are not finite, no triangles.
scene::TriangleMesh read_mesh(const std::string& path);

/// The same of the contents of a file; messages are without its name. For PLY and OBJ in turn.
scene::TriangleMesh parse_ply(std::string_view contents);
scene::TriangleMesh parse_obj(std::string_view contents);

/// A fault of the contents of a mesh file, without the file's name. read_mesh turns it into an Error.
struct MeshFault {
    std::string message;
};

}  // namespace dapple::input
