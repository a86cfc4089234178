#include "report/heat_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace dapple::report {
namespace {

constexpr Color kNotANumber{255, 0, 255};

/// Every tenth of the map "inferno" by S. van der Walt and N. Smith (CC0): its lightness grows evenly.
constexpr std::array<Color, 11> kHeat{{{0, 0, 4},
                                       {22, 11, 57},
                                       {66, 10, 104},
                                       {106, 23, 110},
                                       {147, 38, 103},
                                       {188, 55, 84},
                                       {221, 81, 58},
                                       {243, 120, 25},
                                       {252, 165, 10},
                                       {246, 215, 70},
                                       {252, 255, 164}}};

/// Blue, white and red of equal lightness at equal distance from the middle, to within 2 of L*.
constexpr std::array<Color, 5> kSigned{
    {{10, 50, 120}, {80, 150, 215}, {255, 255, 255}, {232, 118, 94}, {122, 16, 38}}};

/// Linear between the entries of a table that cover [0, 1].
template <std::size_t count>
Color between(const std::array<Color, count>& table, double share) {
    const double place = share * static_cast<double>(count - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(place), count - 2);
    const double part = place - static_cast<double>(i);
    const auto mixed = [part](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(std::lround((1 - part) * a + part * b));
    };
    const Color &a = table[i], &b = table[i + 1];
    return {mixed(a.red, b.red), mixed(a.green, b.green), mixed(a.blue, b.blue)};
}

}  // namespace

Color heat(double value) {
    return std::isnan(value) ? kNotANumber : between(kHeat, std::clamp(value, 0.0, 1.0));
}

Color signed_heat(double value) {
    return std::isnan(value) ? kNotANumber : between(kSigned, (std::clamp(value, -1.0, 1.0) + 1) / 2);
}

std::vector<std::uint8_t> heat_map(std::span<const float> values, double full) {
    assert(full > 0);
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * values.size());
    for (const float value : values) {
        const Color color = heat(value / full);
        rgb.insert(rgb.end(), {color.red, color.green, color.blue});
    }
    return rgb;
}

void draw_scale(Canvas& canvas, int x, int y, int width, int height, double full, const std::string& label) {
    constexpr Color kInk{225, 225, 225};
    const int bar = std::max(height / 3, 1);
    for (int column = 0; column < width; ++column) {
        canvas.fill(x + column, y, 1, bar, heat((column + 0.5) / width));
    }
    const std::string end = short_number(full);
    // One line for numbers and label, smaller where they would run into one another.
    int size = height - bar;
    const auto needed = [&](int text_size) {
        return text_width(text_size, "0") + text_width(text_size, label) + text_width(text_size, end) +
               2 * text_size;
    };
    while (size > 8 && needed(size) > width) --size;
    const int top = y + bar;
    canvas.text(x, top, size, kInk, "0");
    canvas.text(x + (width - text_width(size, label)) / 2, top, size, kInk, label);
    canvas.text(x + width - text_width(size, end), top, size, kInk, end);
}

}  // namespace dapple::report
