#include "grids/density_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>
#include <vector>

#include "base/error.h"
#include "grids/grid_buffer.h"

namespace dapple::grids {
namespace {

const glm::dmat4 kIdentity{1.0};

/// Voxels in an array, for comparison.
struct Dense {
    glm::ivec3 low;
    glm::ivec3 size;
    std::vector<float> values;

    float voxel(const glm::ivec3& at) const {
        const glm::ivec3 v = at - low;
        if (glm::any(glm::lessThan(v, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(v, size))) return 0;
        return values[static_cast<std::size_t>((v.z * size.y + v.y) * size.x + v.x)];
    }
    /// Trilinear, in double.
    double density(const glm::dvec3& at) const {
        const glm::dvec3 least = glm::floor(at);
        const glm::dvec3 share = at - least;
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            const glm::dvec3 weight = glm::mix(1.0 - share, share, glm::dvec3(step));
            sum += weight.x * weight.y * weight.z * static_cast<double>(voxel(glm::ivec3(least) + step));
        }
        return sum;
    }
};

/// Clusters of voxels in blocks across the origin, most blocks empty.
Dense sparse_voxels() {
    Dense dense{{-27, -14, -19}, {61, 37, 45}, {}};
    dense.values.resize(61UL * 37 * 45, 0.0F);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> value(0.1F, 3.0F);
    for (int cluster = 0; cluster < 12; ++cluster) {
        const glm::ivec3 corner(random() % 53, random() % 29, random() % 37);
        for (int n = 0; n < 60; ++n) {
            const glm::ivec3 v = corner + glm::ivec3(random() % 8, random() % 8, random() % 8);
            dense.values[static_cast<std::size_t>((v.z * 37 + v.y) * 61 + v.x)] = value(random);
        }
    }
    return dense;
}

TEST(DensityGrid, TrilinearBetweenHandValues) {
    // Corners at x + 2 y + 4 z.
    const std::vector<float> values{1, 2, 4, 8, 16, 32, 64, 128};
    const auto grid = DensityGrid::from_values({5, -3, 7}, {2, 2, 2}, values, kIdentity);
    DensityGrid::Reader reader(*grid);
    EXPECT_EQ(reader.density({5, -3, 7}), 1);
    EXPECT_EQ(reader.density({6, -2, 8}), 128);
    EXPECT_EQ(reader.density({5.5, -3, 7}), 1.5);
    EXPECT_EQ(reader.density({5, -2.75, 7}), 1.75);
    EXPECT_EQ(reader.density({5, -3, 7.5}), 8.5);
    EXPECT_EQ(reader.density({5.5, -2.5, 7.5}), 255.0F / 8);
    // It falls to 0 over the voxel around.
    EXPECT_EQ(reader.density({4.5, -3, 7}), 0.5);
    EXPECT_EQ(reader.density({6.75, -2, 8}), 32);
    EXPECT_EQ(reader.density({4, -3, 7}), 0);
    EXPECT_EQ(reader.density({7, -2, 8}), 0);
    EXPECT_EQ(grid->low(), glm::ivec3(5, -3, 7));
    EXPECT_EQ(grid->high(), glm::ivec3(6, -2, 8));
    EXPECT_EQ(grid->maximum(), 128);
    EXPECT_EQ(grid->active_voxels(), 8U);
    EXPECT_GE(grid->bytes(), 512 * sizeof(float));
}

TEST(DensityGrid, SparseVoxelsAreThoseOfTheArray) {
    const Dense dense = sparse_voxels();
    const auto grid = DensityGrid::from_values(dense.low, dense.size, dense.values, kIdentity);
    DensityGrid::Reader reader(*grid);
    std::size_t active = 0;
    glm::ivec3 low(1000);
    glm::ivec3 high(-1000);
    for (int z = -40; z < 40; ++z) {
        for (int y = -30; y < 40; ++y) {
            for (int x = -40; x < 50; ++x) {
                const glm::ivec3 at(x, y, z);
                const float expected = dense.voxel(at);
                ASSERT_EQ(reader.voxel(at), expected) << x << " " << y << " " << z;
                if (expected == 0) continue;
                ++active;
                low = glm::min(low, at);
                high = glm::max(high, at);
            }
        }
    }
    EXPECT_EQ(grid->active_voxels(), active);
    EXPECT_EQ(grid->low(), low);
    EXPECT_EQ(grid->high(), high);
}

TEST(DensityGrid, CellsAndSamplesAtRandomPlaces) {
    const Dense dense = sparse_voxels();
    const auto grid = DensityGrid::from_values(dense.low, dense.size, dense.values, kIdentity);
    DensityGrid::Reader reader(*grid);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-34, 40);
    double largest = 0;
    for (int i = 0; i < 200000; ++i) {
        const glm::dvec3 at(place(random), place(random), place(random));
        const double expected = dense.density(at);
        // Three roundings of numbers below 3 in float, and that of the place within its cell.
        ASSERT_NEAR(static_cast<double>(reader.density(at)), expected, 2e-6);
        largest = std::max(largest, expected);
        const glm::ivec3 least(glm::floor(at));
        float corners[8];
        reader.cell(least, corners);
        for (int c = 0; c < 8; ++c) {
            ASSERT_EQ(corners[c], dense.voxel(least + glm::ivec3(c & 1, c >> 1 & 1, c >> 2)));
        }
    }
    EXPECT_GT(largest, 1);  // some of the places were in the density
}

TEST(DensityGrid, BlocksAreEmptyWhereAllVoxelsAre) {
    const Dense dense = sparse_voxels();
    const auto grid = DensityGrid::from_values(dense.low, dense.size, dense.values, kIdentity);
    DensityGrid::Reader reader(*grid);
    int empty = 0;
    int full = 0;
    for (int z = -5; z <= 5; ++z) {
        for (int y = -5; y <= 5; ++y) {
            for (int x = -5; x <= 5; ++x) {
                const glm::ivec3 block = 8 * glm::ivec3(x, y, z);
                bool expected = true;
                for (int n = 0; n < 512; ++n) {
                    expected &= dense.voxel(block + glm::ivec3(n & 7, n >> 3 & 7, n >> 6)) == 0;
                }
                for (const glm::ivec3 inside : {glm::ivec3(0), glm::ivec3(7), glm::ivec3(3, 0, 5)}) {
                    ASSERT_EQ(reader.block_is_empty(block + inside), expected) << x << " " << y << " " << z;
                }
                ++(expected ? empty : full);
            }
        }
    }
    EXPECT_GT(empty, 100);
    EXPECT_GT(full, 20);
}

TEST(DensityGrid, BlocksOfCellsAreOccupiedWhereTheyReachVoxels) {
    const Dense dense = sparse_voxels();
    const auto grid = DensityGrid::from_values(dense.low, dense.size, dense.values, kIdentity);
    const CellBlocks* blocks = grid->cell_blocks();
    ASSERT_NE(blocks, nullptr);
    EXPECT_EQ(blocks->first, (grid->low() - 1) >> 3);
    EXPECT_EQ(blocks->first + blocks->count - 1, grid->high() >> 3);
    DensityGrid::Reader reader(*grid);
    const glm::ivec3 count = blocks->count;
    const int all = count.x * count.y * count.z;
    int occupied = 0;
    for (int i = 0; i < all; ++i) {
        const glm::ivec3 block =
            blocks->first + glm::ivec3(i % count.x, i / count.x % count.y, i / count.x / count.y);
        bool expected = false;
        for (int k = 0; k < 8; ++k)
            expected |= !reader.block_is_empty(8 * (block + glm::ivec3(k & 1, k >> 1 & 1, k >> 2)));
        ASSERT_EQ(blocks->at(block), expected) << i;
        occupied += expected ? 1 : 0;
    }
    EXPECT_GT(occupied, 20);
    EXPECT_LT(occupied, all);
    const auto without = DensityGrid::from_values(dense.low, dense.size, dense.values, kIdentity,
                                                  static_cast<std::size_t>(all) - 1);
    EXPECT_EQ(without->cell_blocks(), nullptr);
    EXPECT_EQ(grid->bytes() - without->bytes(), 8 * blocks->occupied.size());
}

TEST(DensityGrid, FullBlockIsNotEmpty) {
    const std::vector<float> ones(512, 1.0F);
    const auto grid = DensityGrid::from_values({-8, 0, 8}, {8, 8, 8}, ones, kIdentity);
    DensityGrid::Reader reader(*grid);
    EXPECT_FALSE(reader.block_is_empty({-8, 0, 8}));
    EXPECT_FALSE(reader.block_is_empty({-1, 7, 15}));
    EXPECT_TRUE(reader.block_is_empty({0, 7, 15}));
}

TEST(DensityGrid, FarAndImpossiblePlacesAreOutside) {
    const std::vector<float> one{1};
    const auto grid = DensityGrid::from_values({0, 0, 0}, {1, 1, 1}, one, kIdentity);
    DensityGrid::Reader reader(*grid);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double far : {1e300, -1e300, infinity, -infinity, nan, 4e9}) {
        EXPECT_EQ(reader.density({far, 0, 0}), 0);
        EXPECT_EQ(reader.density({0, far, far}), 0);
    }
    constexpr int largest = std::numeric_limits<int>::max();
    float corners[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    reader.cell({largest, -largest - 1, largest}, corners);
    EXPECT_THAT(corners, testing::Each(0.0F));
    EXPECT_EQ(reader.voxel({largest, 0, -largest - 1}), 0);
    EXPECT_TRUE(reader.block_is_empty({largest, largest, largest}));
}

TEST(DensityGrid, NoVoxelsAreAnEmptyGrid) {
    const std::vector<float> zeros(27, 0.0F);
    for (const auto& grid : {DensityGrid::from_values({1, 2, 3}, {3, 3, 3}, zeros, kIdentity),
                             DensityGrid::from_values({1, 2, 3}, {0, 0, 0}, {}, kIdentity)}) {
        EXPECT_TRUE(grid->empty());
        EXPECT_EQ(grid->active_voxels(), 0U);
        DensityGrid::Reader reader(*grid);
        EXPECT_EQ(reader.voxel({1, 2, 3}), 0);
        EXPECT_EQ(reader.density({1.5, 2.5, 3.5}), 0);
        EXPECT_TRUE(reader.block_is_empty({0, 0, 0}));
        float corners[8] = {1, 1, 1, 1, 1, 1, 1, 1};
        reader.cell({1, 2, 3}, corners);
        EXPECT_THAT(corners, testing::Each(0.0F));
    }
}

TEST(DensityGrid, TransformIsKeptAndMustHaveVolume) {
    const std::vector<float> one{1};
    const glm::dmat4 transform =
        glm::rotate(glm::translate(kIdentity, {1.0, 2.0, 3.0}), 0.3, {0.0, 1.0, 0.0}) *
        glm::scale(kIdentity, {0.1, 0.2, 0.3});
    EXPECT_EQ(DensityGrid::from_values({0, 0, 0}, {1, 1, 1}, one, transform)->file_from_index(), transform);
    for (const double side : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
        const glm::dmat4 flat = glm::scale(kIdentity, {1.0, side, 1.0});
        EXPECT_THROW(DensityGrid::from_values({0, 0, 0}, {1, 1, 1}, one, flat), Error);
    }
}

TEST(DensityGrid, ValuesThatAreNoDensity) {
    for (const float value :
         {-1e-6F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const std::vector<float> values{1, value};
        try {
            DensityGrid::from_values({4, 0, 0}, {2, 1, 1}, values, kIdentity);
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            EXPECT_THAT(error.what(), testing::HasSubstr("at 5, 0, 0"));
        }
    }
}

}  // namespace
}  // namespace dapple::grids
