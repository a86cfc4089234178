#include "grids/dense_bricks.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <string>

#include "base/error.h"
#include "base/parallel.h"

namespace dapple::grids {
namespace {

constexpr std::size_t kTile = 64;  // bricks

/// As near to a cube as whole numbers allow.
glm::ivec3 size_for(std::size_t bricks) {
    const auto all = static_cast<double>(bricks);
    const int x = static_cast<int>(std::ceil(std::cbrt(all)));
    const int y = static_cast<int>(std::ceil(std::sqrt(all / x)));
    const int z = static_cast<int>(std::ceil(all / (static_cast<double>(x) * y)));
    return {x, y, z};
}

}  // namespace

DenseBricks dense_bricks(const DensityGrid& grid, int largest) {
    const CellBlocks* blocks = grid.cell_blocks();
    if (!blocks)
        throw Error(ExitCode::input_unreadable,
                    "the grid's voxels lie too far apart for adaptive_beams, over more than " +
                        std::to_string(DensityGrid::kMostBlocks) +
                        " blocks of 8 x 8 x 8; crop it, or use sliced_beams");
    DenseBricks bricks;
    bricks.first = blocks->first;
    bricks.count = blocks->count;
    bricks.scale = grid.maximum();
    std::vector<glm::ivec3> places;
    for (int z = 0; z < blocks->count.z; ++z)
        for (int y = 0; y < blocks->count.y; ++y)
            for (int x = 0; x < blocks->count.x; ++x) {
                const glm::ivec3 block = blocks->first + glm::ivec3(x, y, z);
                const bool occupied = blocks->at(block);
                bricks.brick.push_back(occupied ? static_cast<std::int32_t>(places.size()) : -1);
                if (occupied) places.push_back(block);
            }
    bricks.size = size_for(places.size());
    const glm::ivec3 extent = bricks.extent();
    if (std::max({extent.x, extent.y, extent.z}) > largest)
        throw Error(ExitCode::input_unreadable,
                    "the grid's " + std::to_string(places.size()) +
                        " blocks of 8 x 8 x 8 voxels do not fit into a texture of " +
                        std::to_string(largest) +
                        " texels a side, which adaptive_beams needs; coarsen it, or use sliced_beams");
    const auto row = static_cast<std::size_t>(extent.x), slice = row * static_cast<std::size_t>(extent.y);
    bricks.texels.assign(slice * static_cast<std::size_t>(extent.z), 0);
    parallel_for(places.size(), kTile, [&](std::size_t begin, std::size_t end) {
        DensityGrid::Reader reader(grid);
        for (std::size_t i = begin; i < end; ++i) {
            const auto number = static_cast<int>(i);
            const glm::ivec3 at(number % bricks.size.x, number / bricks.size.x % bricks.size.y,
                                number / (bricks.size.x * bricks.size.y));
            const glm::ivec3 low = DenseBricks::kCells * places[i];
            const auto first = static_cast<std::size_t>(DenseBricks::kVoxels * at.z) * slice +
                               static_cast<std::size_t>(DenseBricks::kVoxels * at.y) * row +
                               static_cast<std::size_t>(DenseBricks::kVoxels * at.x);
            for (int z = 0; z < DenseBricks::kVoxels; ++z)
                for (int y = 0; y < DenseBricks::kVoxels; ++y)
                    for (int x = 0; x < DenseBricks::kVoxels; ++x)
                        bricks.texels[first + static_cast<std::size_t>(z) * slice +
                                      static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x)] =
                            glm::packHalf1x16(reader.voxel(low + glm::ivec3(x, y, z)) / bricks.scale);
        }
    });
    return bricks;
}

std::uint64_t brick_bytes(const VdbGridInfo& grid) {
    if (grid.active_voxels <= 0) return 0;
    const glm::dvec3 size = glm::dvec3(grid.high >> 3) - glm::dvec3((grid.low - 1) >> 3) + 1.0;
    const double box = size.x * size.y * size.z;
    if (box > static_cast<double>(DensityGrid::kMostBlocks)) return 0;
    // Loading holds two trees, each with 512 floats a leaf; what is no leaf is a tile, full of voxels. Cells
    // reach one voxel down, into seven more blocks.
    constexpr double kLeafBytes = 2.0 * 512 * sizeof(float);
    const double full = static_cast<double>(grid.active_voxels) / 512;
    const double reached = 8 * (static_cast<double>(grid.loading_bytes) / kLeafBytes + full);
    const double occupied = grid.loading_bytes > 0 ? std::min(box, reached) : box;
    // Twice: in a buffer and in the texture. And numbers of bricks.
    constexpr double kBrickBytes =
        2.0 * DenseBricks::kVoxels * DenseBricks::kVoxels * DenseBricks::kVoxels * sizeof(std::uint16_t);
    return static_cast<std::uint64_t>(occupied * kBrickBytes + box * 2 * sizeof(std::int32_t));
}

}  // namespace dapple::grids
