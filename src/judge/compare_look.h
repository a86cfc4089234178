#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "color/grader.h"
#include "judge/sequence_reader.h"
#include "metrics/picture.h"

namespace dapple::judge {

/// One frame of one sequence as it is shown and measured.
struct ComparedPicture {
    std::vector<std::uint8_t> rgb;  ///< graded, interleaved rows; empty where there is no picture
    metrics::Picture light;         ///< luminance and excluded pixels
    std::string blank;              ///< why there is no picture
};

/// How pictures are looked at. Linear ones are turned from the primaries of their file (those of Rec.709
/// where it names none) to those of the config's scene_linear, where these are known, and graded;
/// display-referred ones are taken as they are.
class Look {
public:
    /// `displayed`: Comparison::displayed. Throws Error as color::Grader does, but what the config does not
    /// have is an Error(usage).
    Look(const color::ViewSettings& view, double exposure, bool displayed);

    /// Rows of a frame that has a picture, as R'G'B' of 8 bits. Rows of a whole picture are the same bits.
    std::vector<std::uint8_t> rows(const ReadFrame& frame, int first, int count) const;
    /// What is measured: with `displayed`, luma of the graded picture.
    metrics::Picture light(const ReadFrame& frame) const;
    ComparedPicture show(const ReadFrame& frame) const;

    /// "sRGB, ACES 1.0 - SDR Video, exposure -0.1".
    std::string description() const;

private:
    image::Image graded(const ReadFrame& frame, int first, int count) const;

    color::Grader grader_;
    color::Grade grade_;
    bool displayed_;
};

}  // namespace dapple::judge
