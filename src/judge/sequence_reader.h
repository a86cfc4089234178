#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "judge/sequence.h"
#include "metrics/picture.h"
#include "metrics/warping.h"

namespace dapple::judge {

/// Of a picture, in pixels.
struct PictureSize {
    int width = 0, height = 0;
    bool operator==(const PictureSize&) const = default;
};

/// What is read of every frame.
struct ReadOptions {
    std::string layer;                 ///< "": R, G, B
    std::string motion_layer;          ///< LAYER.X and .Y of the first sequence; empty: none
    bool content_hash = false;         ///< of the whole file, against the manifest
    std::vector<std::int64_t> frames;  ///< ascending; empty: all from the first to the last
    std::optional<PictureSize> size;   ///< of all pictures; else of each sequence's first that can be read
};

/// One frame, or why it cannot be had.
struct ReadFrame {
    std::int64_t frame = 0;
    std::string path;
    std::optional<metrics::Picture> picture;  ///< in the primaries of the file
    std::optional<metrics::Motion> motion;
    bool display_referred = false;  ///< code values of a display: a PNG, or graded by dapple
    std::optional<image::Chromaticities> chromaticities;  ///< of the file, where it says them
    std::string fault;                                    ///< one line under 1 KiB, where there is no picture
    bool missing = false;                                 ///< there is no such file
    std::uint64_t bytes = 0;
    std::string content_hash;
};

/// R, G, B of the frame's picture in linear Rec.709, which HDR-FLIP wants; luminance stays.
void to_rec709(ReadFrame& frame);

/// Reads the frames of sequences in order, all sequences' frame t together, one step ahead of the caller in a
/// thread of its own, so that reading overlaps with computing. Memory: two steps, the caller's and the next.
/// A file that is missing, no picture, damaged, or of a wrong size (ReadOptions::size) is a frame with a
/// fault; next() does not throw.
class SequenceReader {
public:
    /// Frames from the smallest first to the largest last of the sequences; missing ones are given as such.
    SequenceReader(std::vector<Sequence> sequences, const ReadOptions& options);
    ~SequenceReader();
    SequenceReader(const SequenceReader&) = delete;
    SequenceReader& operator=(const SequenceReader&) = delete;

    /// The next frame of every sequence, in their order; empty at the end.
    std::vector<ReadFrame> next();
    /// CPU seconds that the reading thread has spent on reading and decoding so far. OpenEXR works in it
    /// alone where image::set_exr_threads(1) was called.
    double decode_cpu_s() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::judge
