#include "report/canvas.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "report/font.h"

namespace dapple::report {
namespace {

std::size_t index(int width, int x, int y) {
    return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
}

/// A whole number of 255ths of `over` on top of `under`, rounded to nearest.
std::uint8_t blended(std::uint8_t under, std::uint8_t over, int coverage) {
    return static_cast<std::uint8_t>((under * (255 - coverage) + over * coverage + 127) / 255);
}

}  // namespace

Canvas::Canvas(int width, int height, Color background) : width_(width), height_(height) {
    assert(width > 0 && height > 0);
    rgb_.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    fill(0, 0, width, height, background);
}

Color Canvas::at(int x, int y) const {
    assert(x >= 0 && y >= 0 && x < width_ && y < height_);
    const std::size_t i = index(width_, x, y);
    return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
}

void Canvas::blend(int x, int y, Color color, int coverage) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    std::uint8_t* pixel = rgb_.data() + index(width_, x, y);
    pixel[0] = blended(pixel[0], color.red, coverage);
    pixel[1] = blended(pixel[1], color.green, coverage);
    pixel[2] = blended(pixel[2], color.blue, coverage);
}

void Canvas::fill(int x, int y, int width, int height, Color color) {
    const int right = std::min(x + width, width_), bottom = std::min(y + height, height_);
    for (int row = std::max(y, 0); row < bottom; ++row) {
        for (int column = std::max(x, 0); column < right; ++column) blend(column, row, color, 255);
    }
}

void Canvas::blit(int x, int y, std::span<const std::uint8_t> rgb, int width, int height) {
    assert(rgb.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const int left = std::max(x, 0), right = std::min(x + width, width_);
    if (left >= right) return;
    for (int row = std::max(y, 0); row < std::min(y + height, height_); ++row) {
        const auto source =
            rgb.subspan(index(width, left - x, row - y), 3 * static_cast<std::size_t>(right - left));
        std::copy(source.begin(), source.end(),
                  rgb_.begin() + static_cast<std::ptrdiff_t>(index(width_, left, row)));
    }
}

void Canvas::line(double x0, double y0, double x1, double y1, Color color, double width) {
    const double reach = width / 2 + 0.5;
    const auto within = [](double value, int size) {
        return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
    };
    const int left = within(std::floor(std::min(x0, x1) - reach), width_);
    const int right = within(std::ceil(std::max(x0, x1) + reach), width_);
    const int top = within(std::floor(std::min(y0, y1) - reach), height_);
    const int bottom = within(std::ceil(std::max(y0, y1) + reach), height_);
    const double along_x = x1 - x0, along_y = y1 - y0;
    const double square = along_x * along_x + along_y * along_y;
    for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            const double from_x = x + 0.5 - x0, from_y = y + 0.5 - y0;
            const double share =
                square > 0 ? std::clamp((from_x * along_x + from_y * along_y) / square, 0.0, 1.0) : 0.0;
            const double distance = std::hypot(from_x - share * along_x, from_y - share * along_y);
            const double coverage = std::clamp(reach - distance, 0.0, 1.0) * std::min(width, 1.0);
            blend(x, y, color, static_cast<int>(std::lround(255 * coverage)));
        }
    }
}

int Canvas::text(int x, int y, int size, Color color, std::string_view text) {
    return set_text(size, text, [&](int ink_x, int ink_y, std::uint8_t coverage) {
        blend(x + ink_x, y + ink_y, color, coverage);
    });
}

std::vector<std::uint8_t> enlarged(std::span<const std::uint8_t> rgb, int width, int height, int factor) {
    assert(rgb.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    if (factor == 1) return {rgb.begin(), rgb.end()};
    const auto times = static_cast<std::size_t>(factor);
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
    std::vector<std::uint8_t> out;
    out.reserve(rgb.size() * times * times);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
        std::vector<std::uint8_t> row;
        row.reserve(row_bytes * times);
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
            const auto pixel = rgb.subspan(y * row_bytes + 3 * x, 3);
            for (std::size_t i = 0; i < times; ++i) row.insert(row.end(), pixel.begin(), pixel.end());
        }
        for (std::size_t i = 0; i < times; ++i) out.insert(out.end(), row.begin(), row.end());
    }
    return out;
}

int text_width(int size, std::string_view text) {
    return set_text(size, text);
}

std::string shortened(int size, std::string_view text, int width) {
    std::string fitting(text);
    while (text_width(size, fitting) > width) {
        if (text.empty()) return "";
        // A whole character: with the bytes that continue it in UTF-8.
        do text.remove_prefix(1);
        while (!text.empty() && (static_cast<unsigned char>(text.front()) & 0xC0) == 0x80);
        fitting = "\u2026" + std::string(text);
    }
    return fitting;
}

}  // namespace dapple::report
