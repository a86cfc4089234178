#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>

#include "grids/density_grid.h"

namespace dapple::grids {

/// A grid that lies in memory as NanoVDB lays it out, aligned to 32 bytes.
struct GridBuffer {
    std::shared_ptr<const std::byte> data;
    std::size_t size = 0;
};

/// The density in a buffer that is not trusted: every offset in it is checked before it is followed, and
/// every value. Throws Error(input_unreadable) where one is wrong; its message names no file.
std::shared_ptr<const DensityGrid> grid_of_buffer(GridBuffer buffer, const glm::dmat4& file_from_index);

/// A grid without active voxels.
std::shared_ptr<const DensityGrid> empty_grid(const glm::dmat4& file_from_index);

}  // namespace dapple::grids
