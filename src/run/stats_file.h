#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "base/stats.h"
#include "run/manifest.h"

namespace dapple::run {

/// What a frame cost, beside the passes and counts of its FrameStats.
struct FrameCost {
    double wall_s = 0;              ///< rendering, grading and writing
    double cpu_s = 0;               ///< the same, all threads of the process
    std::uint64_t peak_memory = 0;  ///< bytes, of the process so far
};

/// One frame as a line of JSON, without the line's end.
std::string stats_line(std::int64_t frame, const FrameCost& cost, const FrameStats& stats,
                       const FrameEntry& entry);

/// Adds a line at the end of the file and syncs it. Throws Error(output_unwritable).
void append_stats(const std::string& path, const std::string& line);

/// Rewrites the file atomically with the last line of each finished frame, in the order of frames; torn lines
/// and those of other frames go. Does nothing where there is no file. Throws Error(output_unwritable).
void tidy_stats(const std::string& path, const std::map<std::int64_t, FrameEntry>& finished);

}  // namespace dapple::run
