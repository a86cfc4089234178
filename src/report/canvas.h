#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dapple::report {

struct Color {
    std::uint8_t red = 0, green = 0, blue = 0;
    bool operator==(const Color&) const = default;
};

/// An 8-bit R'G'B' picture to compose into, interleaved rows from the top left. What lies outside is cut off.
class Canvas {
public:
    Canvas(int width, int height, Color background = {});

    int width() const { return width_; }
    int height() const { return height_; }
    std::span<const std::uint8_t> rgb() const { return rgb_; }
    Color at(int x, int y) const;

    void fill(int x, int y, int width, int height, Color color);
    /// Copies interleaved rows of a picture, bit by bit.
    void blit(int x, int y, std::span<const std::uint8_t> rgb, int width, int height);
    /// A line between two points, anti-aliased, with round ends. Pixels have their centres at + 0.5: a line
    /// of width 1 along centres fills exactly their row or column.
    void line(double x0, double y0, double x1, double y1, Color color, double width = 1);
    /// UTF-8 text on one line in the built-in font, `size` pixels from line to line, its top left at (x, y);
    /// anti-aliased. Characters that the font lacks are drawn as a box. Rounding may take ink a pixel beyond
    /// the line. Returns its width in pixels.
    int text(int x, int y, int size, Color color, std::string_view text);

private:
    /// `color` over a pixel, coverage in 255ths; nothing outside.
    void blend(int x, int y, Color color, int coverage);

    int width_, height_;
    std::vector<std::uint8_t> rgb_;
};

/// Every pixel of interleaved rows as a square of factor x factor.
std::vector<std::uint8_t> enlarged(std::span<const std::uint8_t> rgb, int width, int height, int factor);

/// Width in pixels that Canvas::text would take.
int text_width(int size, std::string_view text);

/// The text, or an ellipsis and as much of its end as fits a width: names differ at their ends. Empty where
/// not even the ellipsis fits.
std::string shortened(int size, std::string_view text, int width);

}  // namespace dapple::report
