#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "report/canvas.h"

namespace dapple::report {

/// Color of a value in [0, 1] (held there; NaN is magenta): dark to bright of even lightness, readable with
/// weak colour sight.
Color heat(double value);
/// Signed values in [-1, 1]: blue below, red above, white at 0.
Color signed_heat(double value);

/// Interleaved R'G'B' of `values` divided by `full`, which is printed beside the picture and fixed for a
/// clip: never scaled a frame.
std::vector<std::uint8_t> heat_map(std::span<const float> values, double full);

/// The colour bar with its scale: 0 at the left, `full` at the right, and what is shown.
void draw_scale(Canvas& canvas, int x, int y, int width, int height, double full, const std::string& label);

/// A rounded number for scales and labels: three digits, "1.25e-05" where that is shorter.
std::string short_number(double value);

}  // namespace dapple::report
