#include "grids/vdb_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/io/File.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

#include "base/error.h"
#include "grids/openvdb_trees.h"
#include "grids/test_files.h"
#include "source_dir.h"

namespace dapple::grids {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kPlenty = std::size_t{1} << 30;

/// Writes them as OpenVDB does, with the metadata that say how many voxels there are or without.
void write_vdb(const std::string& path, const openvdb::GridCPtrVec& grids, bool with_statistics = true) {
    openvdb::initialize();
    openvdb::io::File file(path);
    file.setGridStatsMetadataEnabled(with_statistics);
    file.write(grids);
    file.close();
}

FloatGrid::Ptr fog(const std::string& name) {
    openvdb::initialize();
    auto grid = FloatGrid::create();
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

/// Densities of 1 in the voxels [0, side)^3.
FloatGrid::Ptr cube(const std::string& name, int side) {
    auto grid = fog(name);
    grid->fill({Coord(0), Coord(side - 1)}, 1.0F);
    return grid;
}

class VdbFile : public testing::Test {
protected:
    /// The error of reading a grid.
    void expect_error(ExitCode code, const testing::Matcher<std::string>& message,
                      const std::string& grid = "density", std::size_t most_bytes = kPlenty) const {
        try {
            read_vdb(path_, grid, most_bytes);
            ADD_FAILURE() << "no error";
        } catch (const Error& error) {
            EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
            const std::string text = error.what();
            EXPECT_THAT(text, testing::StartsWith(path_ + ": "));
            EXPECT_THAT(text, message);
            EXPECT_LT(text.size(), 1024U);
            EXPECT_THAT(text, Not(HasSubstr("\n")));
        }
    }

    TestFolder folder_{testing::UnitTest::GetInstance()->current_test_info()->name()};
    std::string path_ = folder_.file("a.vdb");
};

TEST_F(VdbFile, VoxelsAreThoseWritten) {
    auto written = fog("density");
    auto values = written->getAccessor();
    std::mt19937 random(1);
    for (int i = 0; i < 5000; ++i) {
        const Coord at(static_cast<int>(random() % 90) - 40, static_cast<int>(random() % 60) - 40,
                       static_cast<int>(random() % 60));
        values.setValue(at, static_cast<float>(random() % 1000) / 100);  // some are 0
    }
    values.setValueOff({-30, 0, 0}, 7.0F);  // an inactive value is no density
    write_vdb(path_, {cube("other", 4), written});

    const auto grid = read_vdb(path_, "density", kPlenty);
    DensityGrid::Reader reader(*grid);
    std::size_t active = 0;
    for (int z = -10; z < 70; ++z) {
        for (int y = -50; y < 30; ++y) {
            for (int x = -50; x < 60; ++x) {
                const bool on = values.isValueOn({x, y, z});
                const float expected = on ? values.getValue({x, y, z}) : 0;
                ASSERT_EQ(reader.voxel({x, y, z}), expected) << x << " " << y << " " << z;
                active += expected > 0 ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(grid->active_voxels(), active);
    EXPECT_EQ(grid->maximum(), 9.99F);
}

TEST_F(VdbFile, WideRegionsOfOneValueStaySmall) {
    auto written = cube("density", 1024);
    written->getAccessor().setValue({5000, 3, 3}, 2.0F);
    write_vdb(path_, {written});
    const auto grid = read_vdb(path_, "density", kPlenty);
    EXPECT_EQ(grid->active_voxels(), (std::size_t{1} << 30) + 1);
    EXPECT_EQ(grid->low(), glm::ivec3(0));
    EXPECT_EQ(grid->high(), glm::ivec3(5000, 1023, 1023));
    EXPECT_LT(grid->bytes(), 2U << 20);  // two upper nodes, a lower one, a leaf
    DensityGrid::Reader reader(*grid);
    EXPECT_EQ(reader.voxel({1023, 0, 512}), 1);
    EXPECT_EQ(reader.voxel({1024, 0, 512}), 0);
    EXPECT_EQ(reader.density({1023.25, 7.5, 512}), 0.75);
    EXPECT_FALSE(reader.block_is_empty({600, 600, 600}));
    EXPECT_TRUE(reader.block_is_empty({1024, 600, 600}));
    EXPECT_EQ(reader.voxel({5000, 3, 3}), 2);
}

TEST_F(VdbFile, HalfAndDoubleAreDensitiesToo) {
    auto half = fog("half");
    half->setSaveFloatAsHalf(true);
    half->getAccessor().setValue({1, 2, 3}, 0.1F);
    auto wide = openvdb::DoubleGrid::create();
    wide->setName("double");
    wide->getAccessor().setValue({1, 2, 3}, 0.1);
    write_vdb(path_, {half, wide});
    const auto read_half = read_vdb(path_, "half", kPlenty);
    const auto read_double = read_vdb(path_, "double", kPlenty);
    EXPECT_NEAR(read_half->maximum(), 0.1, 0.1 / 2048);  // 11 bits of a half's significand, rounded
    EXPECT_EQ(read_double->maximum(), 0.1F);
    EXPECT_EQ(read_double->low(), glm::ivec3(1, 2, 3));
}

TEST_F(VdbFile, TransformTakesVoxelsToWhereTheFileHasThem) {
    auto grid = cube("density", 2);
    auto transform = openvdb::math::Transform::createLinearTransform(0.25);
    transform->preScale(openvdb::Vec3d(1, 2, 3));
    transform->postRotate(0.7, openvdb::math::Y_AXIS);
    transform->postTranslate({10, -3, 0.5});
    grid->setTransform(transform);
    write_vdb(path_, {grid});
    const glm::dmat4 file_from_index = read_vdb(path_, "density", kPlenty)->file_from_index();
    for (const glm::dvec3 at : {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(3.5, -7, 11)}) {
        const openvdb::Vec3d expected = transform->indexToWorld(openvdb::Vec3d(at.x, at.y, at.z));
        const glm::dvec4 found = file_from_index * glm::dvec4(at, 1);
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], expected[axis], 1e-12);
    }
}

TEST_F(VdbFile, EmptyGridIsEmpty) {
    auto zeros = cube("zeros", 3);
    zeros->fill({Coord(0), Coord(2)}, 0.0F);
    write_vdb(path_, {fog("density"), zeros});
    EXPECT_TRUE(read_vdb(path_, "density", kPlenty)->empty());
    EXPECT_TRUE(read_vdb(path_, "zeros", kPlenty)->empty());
}

TEST_F(VdbFile, InfoListsGrids) {
    auto velocity = openvdb::Vec3SGrid::create();
    velocity->setName("velocity");
    velocity->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    auto density = cube("density", 3);
    for (const bool with_statistics : {true, false}) {
        write_vdb(path_, {velocity, density, fog("flame")}, with_statistics);
        const std::vector<VdbGridInfo> infos = read_vdb_info(path_);
        ASSERT_EQ(infos.size(), 3U);
        EXPECT_EQ(infos[0].name, "density");
        EXPECT_EQ(infos[0].value_type, "float");
        EXPECT_EQ(infos[0].grid_class, "fog volume");
        EXPECT_EQ(infos[0].active_voxels, 27);
        EXPECT_EQ(infos[0].low, glm::ivec3(0));
        EXPECT_EQ(infos[0].high, glm::ivec3(2));
        EXPECT_EQ(infos[0].voxel_size, glm::dvec3(1));
        EXPECT_GE(infos[0].loading_bytes, 2 * 512 * sizeof(float));
        EXPECT_EQ(infos[2].name, "velocity");
        EXPECT_EQ(infos[2].value_type, "vec3s");
        EXPECT_EQ(infos[2].voxel_size, glm::dvec3(0.5));
        EXPECT_EQ(infos[1].active_voxels, 0);
        EXPECT_EQ(infos[1].low, glm::ivec3(0));
        EXPECT_EQ(infos[1].high, glm::ivec3(-1));
    }
}

TEST_F(VdbFile, MissingFileAndFolder) {
    expect_error(ExitCode::input_unreadable, HasSubstr("No such file"));
    std::filesystem::create_directory(path_);
    expect_error(ExitCode::input_unreadable, HasSubstr("no regular file"));
    EXPECT_THROW(read_vdb_info(path_), Error);
}

TEST_F(VdbFile, MissingGridIsToldWithThosePresent) {
    write_vdb(path_, {cube("smoke", 2), fog("flame")});
    expect_error(ExitCode::input_unreadable, AllOf(HasSubstr("'density'"), HasSubstr("flame, smoke")));
    openvdb::GridCPtrVec many;
    for (int i = 0; i < 200; ++i) many.push_back(fog(std::string(100, 'x') + std::to_string(i)));
    write_vdb(path_, many);
    expect_error(ExitCode::input_unreadable, HasSubstr("more"));
    write_vdb(path_, {});
    expect_error(ExitCode::input_unreadable, HasSubstr("no grids"));
}

TEST_F(VdbFile, TypesThatAreNoDensity) {
    const auto vectors = openvdb::Vec3SGrid::create();
    vectors->setName("vectors");
    const auto bits = openvdb::BoolGrid::create();
    bits->setName("bits");
    const auto numbers = openvdb::Int32Grid::create();
    numbers->setName("numbers");
    const auto surface = cube("surface", 2);
    surface->setGridClass(openvdb::GRID_LEVEL_SET);
    write_vdb(path_, {vectors, bits, numbers, surface});
    expect_error(ExitCode::input_unreadable, HasSubstr("vec3s"), "vectors");
    expect_error(ExitCode::input_unreadable, HasSubstr("bool"), "bits");
    expect_error(ExitCode::input_unreadable, HasSubstr("int32"), "numbers");
    expect_error(ExitCode::input_unreadable, HasSubstr("level set"), "surface");
}

TEST_F(VdbFile, ValuesThatAreNoDensityAreCountedAndPlaced) {
    auto grid = cube("density", 20);
    auto values = grid->getAccessor();
    values.setValue({9, 1, 2}, std::numeric_limits<float>::quiet_NaN());
    values.setValue({10, 1, 2}, std::numeric_limits<float>::infinity());
    values.setValue({3, 4, 5}, -1e-9F);
    write_vdb(path_, {grid});
    expect_error(ExitCode::input_unreadable,
                 AllOf(HasSubstr("2 voxels that are NaN or infinite (the first at 9, 1, 2)"),
                       HasSubstr("1 voxel that is negative (the first at 3, 4, 5)")));
}

TEST_F(VdbFile, FrustumIsRefused) {
    auto grid = cube("density", 2);
    grid->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 2, 1));
    write_vdb(path_, {grid});
    expect_error(ExitCode::input_unreadable, HasSubstr("not linear"));
}

TEST_F(VdbFile, VoxelsAtTheEndsOfTheIndexRange) {
    auto grid = fog("density");
    grid->getAccessor().setValue({std::numeric_limits<int>::max() - 1, 0, 0}, 1.0F);
    write_vdb(path_, {grid});
    expect_error(ExitCode::input_unreadable, HasSubstr("too far out"));
}

TEST_F(VdbFile, MoreThanTheBudgetIsNotLoaded) {
    write_vdb(path_, {cube("density", 100)});
    const std::uint64_t needed = read_vdb_info(path_).at(0).loading_bytes;
    EXPECT_GT(needed, std::size_t{1} << 20);
    EXPECT_FALSE(read_vdb(path_, "density", needed)->empty());
    expect_error(ExitCode::out_of_memory_budget, AllOf(HasSubstr("1000000 voxels"), HasSubstr("MiB")),
                 "density", needed - 1);
}

TEST_F(VdbFile, HugeCountsAreRefusedByWhatTheFileSays) {
    write_vdb(path_, {cube("density", 4)});
    std::string bytes = read_bytes(path_);
    // Of a metadatum: its name, the length and name of its type, the length and bytes of its value.
    const std::size_t name = bytes.find("file_mem_bytes");
    ASSERT_NE(name, std::string::npos);
    const std::size_t value = name + 14 + 4 + 5 + 4;  // "int64"
    std::int64_t claim = 0;
    std::memcpy(&claim, &bytes[value], sizeof claim);
    ASSERT_EQ(claim, static_cast<std::int64_t>(read_vdb_info(path_).at(0).loading_bytes) / 2);
    for (const std::int64_t lie : {std::int64_t{1} << 40, std::numeric_limits<std::int64_t>::max()}) {
        std::memcpy(&bytes[value], &lie, sizeof lie);
        write_bytes(path_, bytes);
        expect_error(ExitCode::out_of_memory_budget, HasSubstr("64 voxels, which take"));
    }
}

#ifndef __SANITIZE_ADDRESS__  // under which memory cannot be limited
TEST_F(VdbFile, MemoryIsLimitedWhateverTheFileSays) {
    auto grid = fog("density");
    auto values = grid->getAccessor();
    for (int x = 0; x < 48; ++x) {
        for (int y = 0; y < 32; ++y) {
            for (int z = 0; z < 32; ++z) values.setValue({8 * x, 8 * y, 8 * z}, 1.0F);  // a leaf each
        }
    }
    ASSERT_GT(grid->memUsage(), std::size_t{100} << 20);  // more than the budget and what is spare
    write_vdb(path_, {grid}, false);
    expect_error(ExitCode::out_of_memory_budget, HasSubstr("may be damaged"), "density",
                 std::size_t{16} << 20);
}
#endif

TEST_F(VdbFile, NoFileAtAll) {
    for (const std::string& content : {std::string(), std::string("not a grid"), std::string(5000, '\0')}) {
        write_bytes(path_, content);
        expect_error(ExitCode::input_unreadable, testing::A<std::string>());
        EXPECT_THROW(read_vdb_info(path_), Error);
    }
}

/// Whatever is cut away: OpenVDB itself looks at no file's length, and takes what is missing for zeros where
/// voxels are not compressed.
TEST_F(VdbFile, CutOffAnywhereIsToldAsThat) {
    openvdb::initialize();
    openvdb::io::File uncompressed(folder_.file("whole.vdb"));
    uncompressed.setCompression(openvdb::io::COMPRESS_NONE);
    uncompressed.write({cube("density", 20)});
    for (const std::string& whole : {read_bytes(DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.0012.vdb"),
                                     read_bytes(folder_.file("whole.vdb"))}) {
        ASSERT_GT(whole.size(), 4000U);
        const std::size_t size = whole.size();
        for (const std::size_t left : {std::size_t{20}, std::size_t{60}, std::size_t{200}, size * 15 / 100,
                                       size / 2, size * 9 / 10, size * 999 / 1000, size - 1}) {
            SCOPED_TRACE(std::to_string(left) + " of " + std::to_string(size) + " bytes");
            write_bytes(path_, whole.substr(0, left));
            expect_error(ExitCode::input_unreadable, HasSubstr("cut off"));
            EXPECT_THROW(read_vdb_info(path_), Error);
        }
        write_bytes(path_, whole);
        EXPECT_FALSE(read_vdb(path_, "density", kPlenty)->empty());
    }
    write_bytes(path_, "");
    expect_error(ExitCode::input_unreadable, HasSubstr("is empty"));
}

TEST_F(VdbFile, LongNamesDoNotMakeLongMessages) {
    const std::string folder = folder_.file(std::string(200, 'f'));
    std::filesystem::create_directories(folder + "/" + std::string(200, 'g') + "/" + std::string(200, 'h'));
    try {
        read_vdb(folder + "/" + std::string(200, 'g') + "/" + std::string(200, 'h') + "/x.vdb",
                 std::string(5000, 'n'), kPlenty);
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_LT(std::strlen(error.what()), 1024U);
        EXPECT_THAT(error.what(), HasSubstr("hhh/x.vdb: No such file"));
    }
}

TEST_F(VdbFile, NothingIsLeftBehind) {
    write_vdb(path_, {cube("density", 30)});
    const std::string temporary = folder_.file("temporary");
    std::filesystem::create_directory(temporary);
    const char* before = std::getenv("TMPDIR");
    const std::string kept = before != nullptr ? before : "";
    ::setenv("TMPDIR", temporary.c_str(), 1);
    read_vdb(path_, "density", kPlenty);
    before != nullptr ? ::setenv("TMPDIR", kept.c_str(), 1) : ::unsetenv("TMPDIR");
    EXPECT_TRUE(std::filesystem::is_empty(temporary));
}

}  // namespace
}  // namespace dapple::grids
