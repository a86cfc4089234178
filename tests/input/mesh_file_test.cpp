#include "input/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace dapple::input {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MeshFile : public testing::Test {
protected:
    MeshFile() {
        folder_ = fs::temp_directory_path() / ("dapple_mesh_" + std::to_string(::getpid()) + "_" +
                                               testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
    }
    ~MeshFile() override { fs::remove_all(folder_); }

    scene::TriangleMesh read(const std::string& name, const std::string& contents) const {
        std::ofstream(folder_ / name, std::ios::binary) << contents;
        return read_mesh((folder_ / name).string());
    }
    // The message for broken contents; it must be one line that begins with the file.
    std::string fault(const std::string& name, const std::string& contents) const {
        try {
            read(name, contents);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            std::string message = error.what();
            EXPECT_EQ(message.rfind((folder_ / name).string() + ": ", 0), 0u) << message;
            EXPECT_EQ(message.find('\n'), std::string::npos);
            return message;
        }
        return "no error";
    }

    fs::path folder_;
};

const std::string kQuadHeader =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kQuad = kQuadHeader + "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n4 0 1 2 3\n";

void expect_quad(const scene::TriangleMesh& mesh) {
    ASSERT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.positions[3], glm::dvec3(0, 1, 0.5));
    ASSERT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 2));
    EXPECT_EQ(mesh.triangles[1], glm::uvec3(0, 2, 3));
}

std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, from.size(), to);
}

// Appends the bytes of a value in little or big endian order.
template <class T>
void put(std::string& bytes, T value, bool big) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof value);
    static_assert(std::endian::native == std::endian::little);
    if (big) std::reverse(raw, raw + sizeof raw);
    bytes.append(raw, sizeof raw);
}

// The quad with a property of every type among the wanted ones, and an element of edges between.
std::string binary_quad(bool big) {
    std::string bytes =
        std::string("ply\r\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
        " 1.0\r\nelement vertex 4\r\nproperty char c\r\nproperty double x\r\nproperty uint16 s16\r\n"
        "property float y\r\nproperty short z\r\nproperty list uint8 int8 extra\r\nproperty float s\r\n"
        "property float t\r\nelement edge 1\r\nproperty int a\r\nproperty uint b\r\nelement face 1\r\n"
        "property uchar flags\r\nproperty list ushort uint32 vertex_index\r\nend_header\r\n";
    const double x[] = {0, 1, 1, 0};
    const float y[] = {0, 0, 1, 1};
    for (int i = 0; i < 4; ++i) {
        put(bytes, std::int8_t{-1}, big);
        put(bytes, x[i], big);
        put(bytes, std::uint16_t{77}, big);
        put(bytes, y[i], big);
        put(bytes, static_cast<std::int16_t>(-3 * i), big);
        put(bytes, std::uint8_t{2}, big);
        put(bytes, std::int8_t{5}, big);
        put(bytes, std::int8_t{6}, big);
        put(bytes, 0.25f * static_cast<float>(i), big);
        put(bytes, 0.5f, big);
    }
    put(bytes, std::int32_t{-9}, big);
    put(bytes, std::uint32_t{9}, big);
    put(bytes, std::uint8_t{0}, big);
    put(bytes, std::uint16_t{4}, big);
    for (std::uint32_t i = 0; i < 4; ++i) put(bytes, i, big);
    return bytes;
}

TEST_F(MeshFile, AsciiPly) {
    expect_quad(read("quad.ply", kQuad));
}

TEST_F(MeshFile, BinaryPlyOfBothByteOrdersAndAllTypes) {
    for (const bool big : {false, true}) {
        const scene::TriangleMesh mesh = read("quad.PLY", binary_quad(big));
        ASSERT_EQ(mesh.positions.size(), 4u);
        EXPECT_EQ(mesh.positions[2], glm::dvec3(1, 1, -6));
        ASSERT_EQ(mesh.uv.size(), 4u);
        EXPECT_EQ(mesh.uv[3], glm::dvec2(0.75, 0.5));
        EXPECT_TRUE(mesh.normals.empty());
        ASSERT_EQ(mesh.triangles.size(), 2u);
        EXPECT_EQ(mesh.triangles[1], glm::uvec3(0, 2, 3));
    }
}

TEST_F(MeshFile, PlyNormalsAreMadeUnit) {
    const scene::TriangleMesh mesh = read(
        "n.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0 0 2 0\n1 0 0 0 1 0\n0 0 1 0 3 4\n3 0 1 2");
    ASSERT_EQ(mesh.normals.size(), 3u);
    EXPECT_EQ(mesh.normals[0], glm::dvec3(0, 1, 0));
    EXPECT_EQ(mesh.normals[2], glm::dvec3(0, 0.6, 0.8));
}

TEST_F(MeshFile, ObjMergesShapesAndIndices) {
    const scene::TriangleMesh mesh =
        read("box.obj",
             "# two shapes\nmtllib none.mtl\no first\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
             "v 0 1 0.1\nvn 0 0 2\nvt 0.5 0.25\nusemtl red\nf 1/1/1 2/1/1 3/1/1 4/1/1\n"
             "o second\nf -4/1/1 -3/1/1 -2/1/1\n");
    ASSERT_EQ(mesh.positions.size(), 4u);                 // equal combinations are one vertex
    EXPECT_EQ(mesh.positions[3], glm::dvec3(0, 1, 0.1));  // in double: 0.1 is not that of a float
    EXPECT_EQ(mesh.normals[0], glm::dvec3(0, 0, 1));
    EXPECT_EQ(mesh.uv[2], glm::dvec2(0.5, 0.25));
    ASSERT_EQ(mesh.triangles.size(), 3u);
    EXPECT_EQ(mesh.triangles[1], glm::uvec3(0, 2, 3));
    EXPECT_EQ(mesh.triangles[2], glm::uvec3(0, 1, 2));
}

TEST_F(MeshFile, ObjWithNormalsInPlacesHasNone) {
    const scene::TriangleMesh mesh =
        read("some.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n");
    EXPECT_TRUE(mesh.normals.empty());
    EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST_F(MeshFile, BrokenPly) {
    const auto broken = [&](const std::string& from, const std::string& to) {
        return fault("broken.ply", with(kQuad, from, to));
    };
    EXPECT_THAT(fault("broken.ply", ""), HasSubstr("not a PLY file"));
    EXPECT_THAT(fault("broken.ply", "solid stl\n"), HasSubstr("not a PLY file"));
    EXPECT_THAT(fault("broken.ply", kQuad.substr(0, 60)), HasSubstr("ends within its header"));
    EXPECT_THAT(fault("broken.ply", kQuad.substr(0, kQuad.size() - 4)), HasSubstr("truncated"));
    EXPECT_THAT(broken("ascii", "ebcdic"), HasSubstr("unknown format \"ebcdic\""));
    EXPECT_THAT(broken("format ascii 1.0\n", ""), HasSubstr("no format"));
    EXPECT_THAT(broken("float y", "quad y"), HasSubstr("unknown type \"quad\""));
    EXPECT_THAT(broken("float y", "float why"), HasSubstr("lack x, y or z"));
    EXPECT_THAT(broken("vertex 4", "vertex -4"), HasSubstr("\"-4\" as number"));
    EXPECT_THAT(broken("vertex 4", "vertex 4000000000"), HasSubstr("do not fit into the file"));
    EXPECT_THAT(broken("vertex 4", "vertex 18446744073709551615"), HasSubstr("do not fit into the file"));
    EXPECT_THAT(broken("face 1", "face 1000000000000"), HasSubstr("do not fit into the file"));
    EXPECT_THAT(broken("list uchar", "list float"), HasSubstr("fractions"));
    EXPECT_THAT(broken("4 0 1", "4000000 0 1"), HasSubstr("longer than the file"));
    EXPECT_THAT(broken("4 0 1", "4 0 4"), HasSubstr("face 0 names a vertex that is not there"));
    EXPECT_THAT(broken("4 0 1", "4 0 -1"), HasSubstr("face 0 names a vertex that is not there"));
    EXPECT_THAT(broken("1 1 0\n", "1 nan 0\n"), HasSubstr("position of vertex 2 is not finite"));
    EXPECT_THAT(broken("1 1 0\n", "1 1e999 0\n"), HasSubstr("position of vertex 2 is not finite"));
    EXPECT_THAT(broken("1 1 0\n", "1 one 0\n"), HasSubstr("\"one\" where a number should be"));
    EXPECT_THAT(broken("face 1", "face 0"), HasSubstr("has no faces"));
    EXPECT_THAT(broken("4 0 1 2 3", "2 0 1"), HasSubstr("has no faces"));
    EXPECT_THAT(broken("vertex 4", "vertex 0"), HasSubstr("has no vertices"));
}

TEST_F(MeshFile, BinaryPlyCutAnywhereIsRefused) {
    const std::string whole = binary_quad(false);
    for (std::size_t length = 0; length < whole.size(); length += 5) {
        EXPECT_NE(fault("cut.ply", whole.substr(0, length)), "no error") << length;
    }
}

TEST_F(MeshFile, BrokenObj) {
    EXPECT_THAT(fault("broken.obj", ""), HasSubstr("has no faces"));
    EXPECT_THAT(fault("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), HasSubstr("not there"));
    EXPECT_THAT(fault("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"), HasSubstr("line 3: \"nan\""));
    EXPECT_THAT(fault("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1\n"), HasSubstr("line 3: too few values"));
    EXPECT_THAT(fault("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1e999 0\nf 1 2 3\n"), HasSubstr("not finite"));
    EXPECT_THAT(fault("broken.obj", "v 0 0 0\nf 1 1 1\nf 0 1 1\n"), HasSubstr("broken.obj: "));
    std::string many = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int i = 0; i < 300; ++i) many += " 1";
    EXPECT_THAT(fault("broken.obj", many + "\n"), HasSubstr("line 4: more than 255 values"));
}

TEST_F(MeshFile, WrongPlaces) {
    EXPECT_THAT(fault("mesh.stl", "solid"), HasSubstr("use .ply or .obj"));
    fs::create_directories(folder_ / "folder.ply");
    EXPECT_THROW(read_mesh((folder_ / "folder.ply").string()), Error);
    try {
        read_mesh((folder_ / "absent.ply").string());
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), HasSubstr("absent.ply: no such file"));
    }
}

}  // namespace
}  // namespace dapple::input
