#include "rays/shape_mesh.h"

#include <array>

namespace dapple::rays {
namespace {

/// Adds the rectangle center +- u +- v; cross(u, v) points outward.
void add_rectangle(scene::TriangleMesh& mesh, const glm::dvec3& center, const glm::dvec3& u,
                   const glm::dvec3& v) {
    const auto first = static_cast<glm::uint>(mesh.positions.size());
    for (const glm::dvec3& corner : {center - u - v, center + u - v, center + u + v, center - u + v}) {
        mesh.positions.push_back(corner);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
    mesh.triangles.emplace_back(first, first + 2, first + 3);
}

}  // namespace

scene::TriangleMesh plane_mesh(const glm::dvec3& size) {
    scene::TriangleMesh mesh;
    add_rectangle(mesh, glm::dvec3(0), glm::dvec3(0, 0, 0.5 * size.z), glm::dvec3(0.5 * size.x, 0, 0));
    return mesh;
}

scene::TriangleMesh box_mesh(const glm::dvec3& size) {
    scene::TriangleMesh mesh;
    const glm::dvec3 half = 0.5 * size;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<glm::dvec3, 3> edge{};  // out of the face, and its two sides in cyclic order
        for (int i = 0; i < 3; ++i) {
            const int along = (axis + i) % 3;
            edge[static_cast<std::size_t>(i)][along] = half[along];
        }
        add_rectangle(mesh, edge[0], edge[1], edge[2]);
        add_rectangle(mesh, -edge[0], edge[2], edge[1]);
    }
    return mesh;
}

}  // namespace dapple::rays
