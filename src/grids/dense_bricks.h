#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "grids/density_grid.h"
#include "grids/vdb_file.h"

namespace dapple::grids {

/// A grid's density as dense bricks in one 3-D texture. A brick has the 9 x 9 x 9 voxels about a block of 8 x
/// 8 x 8 cells, so that linear filtering within it is the trilinear density; blocks without density have
/// none.
struct DenseBricks {
    static constexpr int kCells = 8;            ///< along a side of a block
    static constexpr int kVoxels = kCells + 1;  ///< and of its brick
    glm::ivec3 first{0};                        ///< block of `brick`'s first entry: a cell's index over 8
    glm::ivec3 count{0};                        ///< blocks along the axes
    std::vector<std::int32_t> brick;            ///< a block, x fastest: its brick; -1: none
    glm::ivec3 size{0};                 ///< bricks of the texture along the axes; they are numbered x fastest
    float scale = 1;                    ///< density where the texture is 1
    std::vector<std::uint16_t> texels;  ///< half floats in [0, 1], kVoxels * size along the axes, x fastest

    glm::ivec3 extent() const { return kVoxels * size; }  ///< texels
};

/// Of a grid that is not empty. Voxels are rounded to 11 bits of their own size. Throws
/// Error(input_unreadable) where the texture would be longer than `largest` texels, or where the grid lies
/// over more blocks than DensityGrid keeps.
DenseBricks dense_bricks(const DensityGrid& grid, int largest);

/// Memory that a grid's bricks take at most, with the copy that they are uploaded from: by the box of its
/// voxels, and by how many blocks they can reach into. 0 where it has none, or lies over too many blocks.
std::uint64_t brick_bytes(const VdbGridInfo& grid);

}  // namespace dapple::grids
