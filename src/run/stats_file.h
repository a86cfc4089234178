#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/stats.h"
#include "metrics/flicker.h"
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

/// Content hashes of the linear pictures that a frame's temporal figures are made from: those of t - 1, t and
/// t + 1, or of t alone where a neighbour is not finished. `finished` must hold the frame.
using TemporalInputs = std::vector<std::string>;
TemporalInputs temporal_inputs(const std::map<std::int64_t, FrameEntry>& finished, std::int64_t frame);

struct TemporalRecord {
    TemporalInputs inputs;
    metrics::FrameFlicker figures;
};

/// The temporal figures of a frame as a line of their own, {"frame": t, "temporal": {...}}: they come after
/// the frame's cost.
std::string temporal_line(std::int64_t frame, const TemporalRecord& record);

/// The last temporal figures of each finished frame whose inputs are still the same. None where there is no
/// file.
std::map<std::int64_t, TemporalRecord> read_temporal_records(
    const std::string& path, const std::map<std::int64_t, FrameEntry>& finished);

/// Rewrites the file atomically with one line for each finished frame, in the order of frames: its last cost
/// and, under "temporal", its last temporal figures where their inputs are still the same. Torn lines and
/// those of other frames go. With a `clip` each measured frame gets its share in it, and a last line {"clip":
/// {...}} sums it up. Does nothing where there is no file. Throws Error(output_unwritable).
void tidy_stats(const std::string& path, const std::map<std::int64_t, FrameEntry>& finished,
                const metrics::ClipFlicker* clip = nullptr);

}  // namespace dapple::run
