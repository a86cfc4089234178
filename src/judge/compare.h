#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/frame_set.h"
#include "color/grader.h"
#include "scene/frame_state.h"

/// `dapple compare`: sequences beside one another as a video and as a contact sheet.
namespace dapple::judge {

/// Which parts the video has. With n sequences each row of panels has n columns.
struct CompareParts {
    bool side = true;        ///< the pictures side by side
    bool wipe = true;        ///< A against B (C, D one after the other) with a moving divider
    bool difference = true;  ///< |A - B|, |A - C|, ... of luminance as heat maps of one fixed scale
    bool slice = true;       ///< one row of every sequence, time down
    bool flicker = true;     ///< mean luminance and flicker of every frame, as curves
};

struct CompareOptions {
    std::vector<std::string> sequences = {};  ///< 2 to 4, as find_sequence takes them
    std::vector<std::string> labels = {};     ///< one for each; empty: what tells their names apart
    std::string video = {};                   ///< MP4 to write; may be empty
    std::string sheet = {};                   ///< PNG to write; may be empty
    std::optional<FrameSet> frames = {};      ///< shown in ascending order; default: those in all clips
    std::optional<scene::Rational> fps = {};  ///< default: of the first manifest, else 24
    color::ViewSettings view = {};  ///< for linear pictures; display-referred ones are shown as they are
    double exposure = 0;            ///< stops, of linear pictures
    CompareParts parts = {};
    std::optional<double> difference_scale = {};  ///< full scale of the heat maps; default: of the clip
    std::optional<int> slice_row = {};            ///< default: the middle one
    int sheet_frames = 6;                         ///< columns of the sheet, at most
};

/// What is to be told while it works.
struct CompareListener {
    std::function<void(const std::string& line)> note;
    std::function<void(const std::string& stage, std::size_t done, std::size_t total)> progress;
    std::function<bool()> stop;  ///< asked between frames
};

enum class CompareEnd { done, stopped };

/// Reads every frame twice: first to measure what is fixed for the clip (scale of the differences, curves,
/// slices), then to compose. A frame that is missing or unreadable in a sequence is drawn as a blank that
/// says so, and told at the end. Memory: two steps of all sequences, one row of every frame. Stopped, it
/// leaves no file. Throws Error: input_unreadable where a sequence has no readable frame, no frame is common
/// or sizes differ; usage for options that do not fit; output_unwritable.
CompareEnd compare(const CompareOptions& options, const CompareListener& listener);

/// The fraction that is meant by a number of frames a second: 24 is 24/1, 23.976 is 24000/1001, others are
/// thousandths.
scene::Rational exact_rate(double fps);

/// What tells names of sequences apart: their last parts, as many as that takes.
std::vector<std::string> short_labels(const std::vector<std::string>& names);

}  // namespace dapple::judge
