#include "input/closed_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace dapple::input {
namespace {

using testing::HasSubstr;

/// A box of 12 triangles; `parted` has vertices of its own for each, as files with normals do.
scene::TriangleMesh box(bool parted = false) {
    scene::TriangleMesh mesh;
    for (int corner = 0; corner < 8; ++corner)
        mesh.positions.emplace_back(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    const auto face = [&](glm::uint a, glm::uint b, glm::uint c, glm::uint d) {
        mesh.triangles.emplace_back(a, b, c);
        mesh.triangles.emplace_back(a, c, d);
    };
    face(0, 2, 3, 1);
    face(4, 5, 7, 6);
    face(0, 1, 5, 4);
    face(2, 6, 7, 3);
    face(0, 4, 6, 2);
    face(1, 3, 7, 5);
    if (parted) {
        scene::TriangleMesh loose;
        for (const glm::uvec3& triangle : mesh.triangles) {
            const auto first = static_cast<glm::uint>(loose.positions.size());
            for (int i = 0; i < 3; ++i) loose.positions.push_back(mesh.positions[triangle[i]]);
            loose.triangles.emplace_back(first, first + 1, first + 2);
        }
        return loose;
    }
    return mesh;
}

std::string fault(const scene::TriangleMesh& mesh) {
    try {
        require_closed(mesh, "body.ply");
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        return error.what();
    }
    return "none";
}

TEST(ClosedMesh, ABoxIsClosedHoweverItsVerticesAreShared) {
    EXPECT_EQ(fault(box()), "none");
    EXPECT_EQ(fault(box(true)), "none");
    scene::TriangleMesh thin = box();  // a triangle without area harms nothing
    thin.triangles.emplace_back(0, 1, 1);
    EXPECT_EQ(fault(thin), "none");
}

TEST(ClosedMesh, AHoleIsNamedByAnEdge) {
    for (const bool parted : {false, true}) {
        scene::TriangleMesh mesh = box(parted);
        mesh.triangles.pop_back();  // corners 1, 7, 5
        EXPECT_EQ(
            fault(mesh),
            "body.ply: glass needs a closed mesh, but 3 of its edges have no second triangle that fits, "
            "such as that from (1, 0, 0) to (1, 0, 1)");
    }
}

TEST(ClosedMesh, TrianglesFaceOutwardsAllOfThem) {
    scene::TriangleMesh mesh = box();
    std::swap(mesh.triangles[3].x, mesh.triangles[3].y);
    EXPECT_THAT(fault(mesh), HasSubstr("3 of its edges"));
    mesh = box();
    for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.x, triangle.y);
    EXPECT_THAT(fault(mesh), HasSubstr("face inwards"));
}

}  // namespace
}  // namespace dapple::input
