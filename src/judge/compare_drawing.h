#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "judge/compare_layout.h"
#include "judge/compare_look.h"
#include "judge/compare_plan.h"
#include "judge/compare_survey.h"
#include "report/canvas.h"

/// What video and sheet have in common.
namespace dapple::judge {

inline constexpr report::Color kGround{24, 24, 28}, kInk{236, 236, 240}, kQuiet{164, 166, 174},
    kBlank{44, 44, 50};

/// Colour of a sequence in tags and curves: apart for weak colour sight too.
report::Color color_of(std::size_t sequence);

/// "A" on its colour, and text in what is left of the line, shortened where that is too little.
void draw_caption(report::Canvas& canvas, const Box& line, std::size_t sequence, const std::string& text);
/// Text alone.
void draw_line(report::Canvas& canvas, const Box& line, const std::string& text);
/// A grey box that says why there is nothing to see.
void draw_blank(report::Canvas& canvas, const Box& box, const std::string& why);

/// "|A - B| / mean of A".
std::string difference_name(const Survey& survey, std::size_t sequence);
/// Why there is no difference; empty where there is one.
std::string difference_blank(const ComparedPicture& a, const ComparedPicture& b, std::size_t sequence);

/// Frame and time, "frame 12, 0.458 s".
std::string frame_text(const Comparison& comparison, std::int64_t frame);

}  // namespace dapple::judge
