// OBJ through tinyobjloader, which takes anything unreadable for 0: the lines that matter are looked over
// first.
#include <tiny_obj_loader.h>

#include <array>
#include <map>
#include <sstream>
#include <vector>

#include "input/mesh_file.h"

namespace dapple::input {
namespace {

struct LineRule {
    std::string_view keyword;
    std::size_t fewest_words;
    std::string_view letters;  ///< that its words are made of
};
constexpr std::array<LineRule, 4> kLineRules{{{"v", 3, "0123456789+-.eE"},
                                              {"vn", 3, "0123456789+-.eE"},
                                              {"vt", 1, "0123456789+-.eE"},
                                              {"f", 3, "0123456789-/"}}};

/// tinyobjloader counts the corners of a face in a byte.
constexpr std::size_t kMostWords = 255;

void check_line(std::string_view line, std::size_t number) {
    constexpr std::string_view blanks = " \t\r";
    line = line.substr(0, line.find('#'));
    std::vector<std::string_view> words;
    for (std::size_t begin = line.find_first_not_of(blanks); begin != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = line.find_first_not_of(blanks, end);
    }
    if (words.empty()) return;
    for (const LineRule& rule : kLineRules) {
        if (words[0] != rule.keyword) continue;
        const std::string place = "line " + std::to_string(number) + ": ";
        if (words.size() - 1 > kMostWords) throw MeshFault{place + "more than 255 values"};
        if (words.size() - 1 < rule.fewest_words)
            throw MeshFault{place + "too few values, or the file is truncated"};
        for (std::size_t i = 1; i < words.size(); ++i) {
            if (words[i].find_first_not_of(rule.letters) != std::string_view::npos) {
                throw MeshFault{place + "\"" + std::string(words[i]) +
                                "\" is not a finite number or an index"};
            }
        }
    }
}

void check_lines(std::string_view contents) {
    std::size_t number = 0;
    while (!contents.empty()) {
        const std::size_t end = contents.find('\n');
        check_line(contents.substr(0, end), ++number);
        if (end == std::string_view::npos) break;
        contents.remove_prefix(end + 1);
    }
}

// OBJ counts positions, normals and texture coordinates apart; a vertex of the mesh is one combination of
// them.
class VertexMerger {
public:
    VertexMerger(const tinyobj::attrib_t& attributes, scene::TriangleMesh& mesh)
        : from_(attributes), mesh_(mesh) {}

    std::uint32_t vertex(const tinyobj::index_t& index) {
        check(index.vertex_index, from_.vertices.size() / 3, true);
        check(index.normal_index, from_.normals.size() / 3, false);
        check(index.texcoord_index, from_.texcoords.size() / 2, false);
        const std::array<int, 3> key{index.vertex_index, index.normal_index, index.texcoord_index};
        const auto [known, is_new] =
            vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
        if (!is_new) return known->second;
        const auto vector = [](const std::vector<double>& values, int i) {
            const double* v = values.data() + 3 * static_cast<std::size_t>(i);
            return glm::dvec3(v[0], v[1], v[2]);
        };
        mesh_.positions.push_back(vector(from_.vertices, index.vertex_index));
        if (index.normal_index >= 0) {
            mesh_.normals.push_back(vector(from_.normals, index.normal_index));
        }
        if (index.texcoord_index >= 0) {
            const double* t = from_.texcoords.data() + 2 * static_cast<std::size_t>(index.texcoord_index);
            mesh_.uv.emplace_back(t[0], t[1]);
        }
        return known->second;
    }

private:
    static void check(int index, std::size_t count, bool needed) {
        if (!needed && index == -1) return;
        if (index < 0 || static_cast<std::size_t>(index) >= count) {
            throw MeshFault{"a face names a vertex that is not there"};
        }
    }

    const tinyobj::attrib_t& from_;
    scene::TriangleMesh& mesh_;
    std::map<std::array<int, 3>, std::uint32_t> vertices_;
};

}  // namespace

scene::TriangleMesh parse_obj(std::string_view contents) {
    check_lines(contents);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning;
    std::string error;
    std::istringstream stream{std::string(contents)};
    const bool triangulate = false;  // fans about the first corner, as for PLY
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream, nullptr, triangulate,
                          false)) {
        throw MeshFault{error.empty() ? "is not an OBJ file" : error};
    }
    scene::TriangleMesh mesh;
    VertexMerger merger(attributes, mesh);
    for (const tinyobj::shape_t& shape : shapes) {
        std::size_t first = 0;
        for (const auto corner_count : shape.mesh.num_face_vertices) {
            const std::size_t corners = corner_count;
            std::vector<std::uint32_t> face;
            for (std::size_t i = 0; i < corners; ++i)
                face.push_back(merger.vertex(shape.mesh.indices[first + i]));
            for (std::size_t i = 2; i < corners; ++i)
                mesh.triangles.emplace_back(face[0], face[i - 1], face[i]);
            first += corners;
        }
    }
    if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
    if (mesh.uv.size() != mesh.positions.size()) mesh.uv.clear();
    return mesh;
}

}  // namespace dapple::input
