#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "judge/compare.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "metrics/flicker.h"

namespace dapple::judge {

/// What the first reading finds of one sequence.
struct SurveyedSequence {
    std::map<std::int64_t, metrics::FrameFlicker> frames;  ///< those with a picture
    metrics::ClipFlicker clip;
    std::vector<std::int64_t> missing;
    std::map<std::int64_t, std::string> unreadable;  ///< and why
    std::size_t excluded = 0;                        ///< pixels that are not finite, in all frames
    /// Comparison::slice_row of every frame in order, graded; rows of frames without a picture are 0.
    std::vector<std::uint8_t> slice;
};

/// What stays fixed for the clip.
struct Survey {
    std::vector<SurveyedSequence> sequences;
    double unit = 1;             ///< differences are divided by it: the mean luminance of A, or 1
    bool relative = false;       ///< it is the mean
    double difference_full = 1;  ///< what the heat maps show brightest, in units
};

/// |luminance of A - luminance of B| / unit of every pixel; NaN where either is excluded.
std::vector<float> difference(const metrics::Picture& a, const metrics::Picture& b, double unit);

/// The smallest of 1, 2, 5 times a power of ten that is not below a positive value.
double round_up(double value);

/// Reads all frames. None where the listener asks to stop.
std::optional<Survey> survey(const Comparison& comparison, const Look& look,
                             const std::optional<double>& difference_scale, const CompareListener& listener);

}  // namespace dapple::judge
