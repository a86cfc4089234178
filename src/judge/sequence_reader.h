#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "judge/sequence.h"
#include "metrics/picture.h"
#include "metrics/warping.h"

namespace dapple::judge {

/// What is read of every frame.
struct ReadOptions {
    std::string layer;          ///< "": R, G, B
    std::string motion_layer;   ///< LAYER.X and .Y, pixels from t to t - 1; empty: none
    bool content_hash = false;  ///< of the whole file, against duplicates and the manifest
};

/// One frame, or why it cannot be had.
struct ReadFrame {
    std::int64_t frame = 0;
    std::string path;
    std::optional<metrics::Picture> picture;  ///< in the primaries of the file
    std::optional<metrics::Motion> motion;
    bool display_referred = false;  ///< code values of a display: a PNG, or graded by dapple
    std::string fault;              ///< one line under 1 KiB, where there is no picture
    bool missing = false;           ///< there is no such file
    std::uint64_t bytes = 0;
    std::string content_hash;
};

/// Reads the frames of sequences in order, all sequences' frame t together, one step ahead of the caller in a
/// thread of its own, so that reading overlaps with computing. Memory: two steps.
class SequenceReader {
public:
    /// Frames from the smallest first to the largest last of the sequences; missing ones are given as such.
    SequenceReader(std::vector<Sequence> sequences, const ReadOptions& options);
    ~SequenceReader();
    SequenceReader(const SequenceReader&) = delete;
    SequenceReader& operator=(const SequenceReader&) = delete;

    /// The next frame of every sequence, in their order; empty at the end.
    std::vector<ReadFrame> next();
    /// CPU seconds spent on reading and decoding so far.
    double decode_cpu_s() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::judge
