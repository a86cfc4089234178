#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grids/vdb_file.h"
#include "source_dir.h"

namespace dapple::grids {
namespace {

std::string smoke(const char* number) {
    return std::string(DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.") + number + ".vdb";
}

/// Figures that `vdb_print -l` and a reading by hand give for these files.
TEST(BlenderSmoke, HasFiveGridsOneOfThemEmpty) {
    const std::vector<VdbGridInfo> infos = read_vdb_info(smoke("0024"));
    std::vector<std::string> names;
    for (const VdbGridInfo& info : infos) {
        names.push_back(info.name);
        EXPECT_NEAR(info.voxel_size.x, 1.0 / 24, 1e-6);
    }
    EXPECT_THAT(names, testing::ElementsAre("density", "flame", "shadow", "temperature", "velocity"));
    EXPECT_EQ(infos[0].active_voxels, 20787);
    EXPECT_EQ(infos[0].low, glm::ivec3(7, 7, 1));
    EXPECT_EQ(infos[0].high, glm::ivec3(40, 40, 46));
    EXPECT_TRUE(read_vdb(smoke("0024"), "flame", std::size_t{1} << 30)->empty());
}

TEST(BlenderSmoke, DensityLiesWhereItsInfoSays) {
    const auto grid = read_vdb(smoke("0024"), "density", std::size_t{1} << 30);
    EXPECT_GT(grid->active_voxels(), 15000U);
    EXPECT_LE(grid->active_voxels(), 20787U);
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(grid->low(), glm::ivec3(7, 7, 1))));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(grid->high(), glm::ivec3(40, 40, 46))));
    // Half floats around 1; voxels of 1/24 m, the first at the domain's corner.
    EXPECT_NEAR(grid->maximum(), 0.98877, 1e-5);
    EXPECT_NEAR(grid->file_from_index()[0][0], 1.0 / 24, 1e-6);
    EXPECT_EQ(glm::dvec3(grid->file_from_index()[3]), glm::dvec3(0));
    DensityGrid::Reader reader(*grid);
    double sum = 0;
    for (int z = 1; z <= 46; ++z) {
        for (int y = 7; y <= 40; ++y) {
            for (int x = 7; x <= 40; ++x) sum += static_cast<double>(reader.voxel({x, y, z}));
        }
    }
    EXPECT_GT(sum / static_cast<double>(grid->active_voxels()), 0.05);
}

}  // namespace
}  // namespace dapple::grids
