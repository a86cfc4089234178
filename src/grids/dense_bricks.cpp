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
        throw Error(ExitCode::device, "the voxels of a grid lie too far apart for textures: over more than " +
                                          std::to_string(DensityGrid::kMostBlocks) + " blocks of 8 x 8 x 8");
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
        throw Error(ExitCode::device, "a grid of " + std::to_string(places.size()) +
                                          " blocks with density does not fit into a texture of " +
                                          std::to_string(largest) + " texels a side");
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

}  // namespace dapple::grids
