#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "judge/compare.h"
#include "judge/sequence.h"
#include "scene/frame_state.h"

namespace dapple::judge {

/// What is compared, once the sequences are found and a frame of each has been looked at.
struct Comparison {
    std::vector<Sequence> sequences;
    std::vector<std::string> labels;
    std::vector<std::int64_t> frames;  ///< ascending
    std::int64_t first = 0;            ///< frame of time 0
    scene::Rational fps;
    int width = 0;  ///< of all pictures
    int height = 0;
    /// At least one sequence is display-referred: luminance is then Rec.709 luma of code values in all of
    /// them, after grading, since light and code values cannot be compared.
    bool displayed = false;
    bool graded = false;  ///< at least one is linear and is graded to be shown
    int slice_row = 0;
};

/// Throws Error as compare() does.
Comparison plan_comparison(const CompareOptions& options);

/// "A", "B", ...
std::string letter(std::size_t sequence);

}  // namespace dapple::judge
