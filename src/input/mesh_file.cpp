#include "input/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace dapple::input {
namespace {

/// Larger files are refused unread.
constexpr std::uintmax_t kLargestFile = std::uintmax_t{4} << 30;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
    throw Error(ExitCode::input_unreadable, clipped(path) + ": " + clipped(what));
}

std::string contents_of(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) fail(path, "no such file");
    if (!std::filesystem::is_regular_file(status)) fail(path, "is not a file");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) fail(path, "cannot be read");
    if (size > kLargestFile) fail(path, "is larger than 4 GiB");
    std::string contents(size, '\0');
    std::ifstream file(path, std::ios::binary);
    if (!file.read(contents.data(), static_cast<std::streamsize>(size))) fail(path, "cannot be read");
    return contents;
}

std::string lower_case_ending(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending;
}

template <class Vector>
bool finite(const Vector& v) {
    for (int i = 0; i < v.length(); ++i) {
        if (!std::isfinite(v[i])) return false;
    }
    return true;
}

// What holds for meshes of every format.
void check(scene::TriangleMesh& mesh) {
    if (mesh.triangles.empty()) throw MeshFault{"has no faces"};
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        if (!finite(mesh.positions[v])) {
            throw MeshFault{"the position of vertex " + std::to_string(v) + " is not finite"};
        }
    }
    for (glm::dvec3& normal : mesh.normals) {
        const double length = glm::length(normal);
        if (!(length > 0) || !std::isfinite(length)) {  // one useless normal: none given
            mesh.normals.clear();
            break;
        }
        normal /= length;
    }
    for (std::size_t v = 0; v < mesh.uv.size(); ++v) {
        if (!finite(mesh.uv[v])) {
            throw MeshFault{"the texture coordinate of vertex " + std::to_string(v) + " is not finite"};
        }
    }
}

}  // namespace

scene::TriangleMesh read_mesh(const std::string& path) {
    const std::string ending = lower_case_ending(path);
    if (ending != ".ply" && ending != ".obj") fail(path, "unknown kind of mesh; use .ply or .obj");
    const std::string contents = contents_of(path);
    try {
        scene::TriangleMesh mesh = ending == ".ply" ? parse_ply(contents) : parse_obj(contents);
        check(mesh);
        return mesh;
    } catch (const MeshFault& fault) {
        fail(path, fault.message);
    }
}

}  // namespace dapple::input
