#pragma once
#include <cstddef>
#include <cstdint>

/// What dapple-read-vdb writes to file descriptor kReplyFile: a Reply, then as many GridEntry as it announces
/// (its standard output is for OpenVDB's own warnings). Program and reader are built together, so the structs
/// are sent as they are.
///
///     dapple-read-vdb info FILE MOST_BYTES          the grids of a file
///     dapple-read-vdb read FILE GRID MOST_BYTES     one grid: its voxels go to file descriptor kVoxelsFile
namespace dapple::grids {

inline constexpr char kReplyMark[8] = {'d', 'a', 'p', 'p', 'l', 'e', 'v', '1'};
inline constexpr int kVoxelsFile = 3;
inline constexpr int kReplyFile = 4;
inline constexpr std::uint32_t kMostGrids = 10000;

/// Address space of the reader beside what MOST_BYTES allows: room for what a library takes on its way.
inline constexpr std::size_t kSpareBytes = std::size_t{64} << 20;

enum class Outcome : std::uint32_t { done, unreadable, too_large };

struct Reply {
    char mark[8] = {};
    Outcome outcome = Outcome::unreadable;
    std::uint32_t grids = 0;          ///< entries that follow
    std::uint64_t voxels_bytes = 0;   ///< read: size of the NanoVDB grid; 0: no active voxels
    double file_from_index[16] = {};  ///< read: columns
    char message[600] = {};           ///< unless done: why; ends with 0
};

struct GridEntry {
    char name[128] = {};  ///< texts end with 0, and are cut to fit
    char value_type[64] = {};
    char grid_class[32] = {};
    std::int64_t active_voxels = 0;
    std::int32_t low[3] = {};
    std::int32_t high[3] = {};
    double voxel_size[3] = {};
    std::uint64_t loading_bytes = 0;
};

}  // namespace dapple::grids
