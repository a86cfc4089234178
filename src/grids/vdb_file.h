#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grids/density_grid.h"

namespace dapple::grids {

/// What an OpenVDB file says of one of its grids before any voxel is read.
struct VdbGridInfo {
    std::string name;
    std::string value_type;  ///< "float", "vec3s", ...
    std::string grid_class;  ///< "fog volume", "level set", "unknown"
    std::int64_t active_voxels = 0;
    glm::ivec3 low{0}, high{-1};  ///< of the active voxels, both included
    glm::dvec3 voxel_size{0};
    std::uint64_t loading_bytes = 0;  ///< memory that reading it takes at most; 0: the file does not say
};

/// The grids of a file, by name. Reading is done by a child process of limited memory: a file that is
/// damaged or asks for too much ends it, not us. Throws Error(input_unreadable) naming the file and, in one
/// short line, why.
std::vector<VdbGridInfo> read_vdb_info(const std::string& path);

/// Reads one grid of scalar density, again in a child process. Throws Error(input_unreadable) where the file
/// or the grid is missing (with the names of those present), of another type, a level set, damaged, or holds
/// values that are negative or not finite; Error(out_of_memory_budget) where loading would take more than
/// `most_bytes`: before, by what the file says, and where it says less than it takes, then. A grid without
/// active voxels is a grid that is empty().
std::shared_ptr<const DensityGrid> read_vdb(const std::string& path, const std::string& grid,
                                            std::size_t most_bytes);

}  // namespace dapple::grids
