#include "ocean/mesh_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "ocean/water_surface.h"
#include "source_dir.h"

namespace dapple::ocean {
namespace {

namespace fs = std::filesystem;

// A folder of files `s.0003.ply`, each a square of 2 m at the height of its number.
class MeshSequence : public testing::Test {
protected:
    MeshSequence() {
        folder_ = fs::temp_directory_path() / ("dapple_sequence_" + std::to_string(::getpid()) + "_" +
                                               testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
        sequence_.pattern = (folder_ / "s.%04d.ply").string();
        sequence_.first_file = 3;
        sequence_.last_file = 9;
    }
    ~MeshSequence() override { fs::remove_all(folder_); }

    void write(int number, const std::string& face = "4 0 3 2 1") const {
        char name[32];
        std::snprintf(name, sizeof name, "s.%04d.ply", number);
        std::ofstream(folder_ / name)
            << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n-1 "
            << number << " -1\n1 " << number << " -1\n1 " << number << " 1\n-1 " << number << " 1\n"
            << face << "\n";
    }
    int shown_at(double time) const {
        return static_cast<int>(sequence_mesh(sequence_, time).mesh.positions[0].y);
    }

    fs::path folder_;
    scene::MeshSequence sequence_;
};

TEST_F(MeshSequence, EarlierFileHoldsAndEndsHold) {
    for (int i = 3; i <= 9; ++i) write(i);
    sequence_.fps = 30000.0 / 1001;
    for (int k = 0; k <= 6; ++k) EXPECT_EQ(shown_at(k / sequence_.fps), 3 + k);
    EXPECT_EQ(shown_at(1.99 / sequence_.fps), 4);
    EXPECT_EQ(shown_at(2.01 / sequence_.fps), 5);
    EXPECT_EQ(shown_at(-1), 3);
    EXPECT_EQ(shown_at(100), 9);
}

TEST_F(MeshSequence, MissingFiles) {
    write(4);
    write(6);
    const double third = 2 / 24.0;  // file 5
    try {
        sequence_mesh(sequence_, third);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), testing::HasSubstr("s.0005.ply: no such file"));
    }
    sequence_.missing = scene::MissingFrames::hold;
    EXPECT_EQ(shown_at(third), 4);
    EXPECT_EQ(shown_at(3 / 24.0), 6);
    EXPECT_EQ(shown_at(1), 6);
    try {
        sequence_mesh(sequence_, 0);  // file 3, and nothing before it
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), testing::HasSubstr("s.0003.ply: no such file, and none before it"));
    }
}

TEST_F(MeshSequence, TurnsFacesUpWhateverTheirOrder) {
    for (const std::string face : {"4 0 3 2 1", "4 0 1 2 3"}) {
        write(3, face);
        const scene::WaterMesh water = sequence_mesh(sequence_, 0);
        ASSERT_EQ(water.mesh.triangles.size(), 2u);
        for (const glm::uvec3& t : water.mesh.triangles) {
            const auto& p = water.mesh.positions;
            EXPECT_GT(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).y, 0);
        }
        for (const glm::dvec3& n : water.mesh.normals) EXPECT_EQ(n, glm::dvec3(0, 1, 0));
        EXPECT_EQ(water.rows, 0);
        EXPECT_EQ(water.height_bound, 3);
        EXPECT_EQ(water.largest_height, 3);
    }
}

TEST_F(MeshSequence, UpAxisScaleAndOffset) {
    write(3);
    sequence_.scale = 0.5;
    sequence_.offset = {10, 20, 30};
    glm::dvec3 first = sequence_mesh(sequence_, 0).mesh.positions[0];  // (-1, 3, -1) in the file
    EXPECT_EQ(first, glm::dvec3(9.5, 21.5, 29.5));
    std::ofstream(folder_ / "s.0003.ply")
        << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
           "float y\nproperty float z\nelement face 1\nproperty list uchar int "
           "vertex_indices\nend_header\n1 2 3\n2 2 3\n2 4 3\n3 0 1 2\n";
    sequence_.up = scene::UpAxis::z;
    first = sequence_mesh(sequence_, 0).mesh.positions[0];
    EXPECT_EQ(first, glm::dvec3(0.5 + 10, 1.5 + 20, -1 + 30));  // (x, z, -y): a turn, no mirror
    write(3);  // the square now stands upright: neither up nor down
    EXPECT_THROW(sequence_mesh(sequence_, 0), Error);
}

TEST_F(MeshSequence, NormalsAreWeightedByArea) {
    // A roof over x: the left half is twice as wide as the right one and half as steep.
    std::ofstream(folder_ / "s.0003.ply")
        << "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_index\n"
           "end_header\n-2 0 0\n0 1 0\n1 0 0\n-2 0 1\n0 1 1\n1 0 1\n"
           "4 0 3 4 1\n4 1 4 5 2\n";
    const scene::WaterMesh water = sequence_mesh(sequence_, 0);
    // At the ridge's end (vertex 1, fans about corners 0 and 1) meet half of the left face, (-1, 2, 0), and
    // all of the right one, 2 (1, 1, 0), as twice areas.
    const glm::dvec3 expected = glm::normalize(glm::dvec3(-1 + 2, 2 + 2, 0));
    EXPECT_LT(glm::length(water.mesh.normals[1] - expected), 1e-15);
    EXPECT_LT(glm::length(water.mesh.normals[0] - glm::normalize(glm::dvec3(-1, 2, 0))), 1e-15);
}

TEST_F(MeshSequence, PatternNeedsOneNumber) {
    sequence_.pattern = (folder_ / "s.ply").string();
    try {
        sequence_mesh(sequence_, 0);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::timeline_invalid);
    }
}

TEST(BlenderOcean, LoadsAsASeaThatFacesUp) {
    scene::Water water;
    water.surface.type = scene::WaterSurfaceType::mesh_sequence;
    scene::MeshSequence& s = water.surface.mesh_sequence;
    s.pattern = DAPPLE_SOURCE_DIR "/sequences/assets/blender-ocean/ocean.####.ply";
    s.first_file = 1;
    s.last_file = 8;
    s.up = scene::UpAxis::z;
    const WaterSurface surface(water);
    double lowest = 0;
    double highest = 0;
    for (int frame = 0; frame < 8; ++frame) {
        const scene::WaterMesh mesh = surface.mesh(frame / 24.0);
        ASSERT_EQ(mesh.mesh.positions.size(), 21025u);
        ASSERT_EQ(mesh.mesh.triangles.size(), 41472u);
        ASSERT_EQ(mesh.mesh.normals.size(), 21025u);
        double projected = 0;
        for (const glm::uvec3& t : mesh.mesh.triangles) {
            const auto& p = mesh.mesh.positions;
            projected += 0.5 * glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).y;
        }
        EXPECT_NEAR(projected, 144, 3);  // 12 m by 12 m; the border is displaced by some cm
        for (const glm::dvec3& p : mesh.mesh.positions) {
            lowest = std::min(lowest, p.y);
            highest = std::max(highest, p.y);
        }
        // That program's displacement is so strong that a fifth of the vertices lie on folds, facing down.
        EXPECT_NEAR(static_cast<double>(mesh.folded_vertices), 0.2 * 21025, 0.01 * 21025);
    }
    EXPECT_NEAR(lowest, -0.73, 0.005);  // as its provenance note says, to its digits
    EXPECT_NEAR(highest, 0.69, 0.005);
}

}  // namespace
}  // namespace dapple::ocean
