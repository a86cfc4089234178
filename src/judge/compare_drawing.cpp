#include "judge/compare_drawing.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace dapple::judge {
namespace {

/// Of a line of so many pixels: text, from line to line, and tags.
int text_size(int height) {
    return height * 9 / 14;
}
int tag_size(int height) {
    return height * 11 / 14;
}
constexpr int kBlankText = 18;  // px from line to line

}  // namespace

report::Color color_of(std::size_t sequence) {
    // After M. Okabe and K. Ito, as bright as a dark ground wants.
    constexpr std::array<report::Color, 4> kColors{
        {{240, 166, 24}, {96, 186, 240}, {30, 190, 140}, {226, 140, 190}}};
    return kColors[sequence % kColors.size()];
}

void draw_caption(report::Canvas& canvas, const Box& line, std::size_t sequence, const std::string& text) {
    const std::string name = letter(sequence);
    const int tag = tag_size(line.height), size = text_size(line.height);
    const int top = line.y + (line.height - tag) / 2, indent = tag + tag / 3;
    canvas.fill(line.x, top, tag, tag, color_of(sequence));
    canvas.text(line.x + (tag - report::text_width(size, name)) / 2, top + (tag - size) / 2, size, kGround,
                name);
    draw_line(canvas, {line.x + indent, line.y, line.width - indent, line.height}, text);
}

void draw_line(report::Canvas& canvas, const Box& line, const std::string& text) {
    const int size = text_size(line.height);
    canvas.text(line.x, line.y + (line.height - size) / 2, size, kInk,
                report::shortened(size, text, line.width));
}

void draw_blank(report::Canvas& canvas, const Box& box, const std::string& why) {
    canvas.fill(box.x, box.y, box.width, box.height, kBlank);
    const int size = std::max(kBlankText, box.width / 30);
    const std::string text = report::shortened(size, why, box.width - 4);
    canvas.text(box.x + (box.width - report::text_width(size, text)) / 2, box.y + (box.height - size) / 2,
                size, kInk, text);
}

std::string difference_name(const Survey& survey, std::size_t sequence) {
    return "|A \u2212 " + letter(sequence) + "|" + (survey.relative ? " / mean of A" : "");
}

std::string difference_blank(const ComparedPicture& a, const ComparedPicture& b, std::size_t sequence) {
    if (a.rgb.empty()) return "A: " + a.blank;
    if (b.rgb.empty()) return letter(sequence) + ": " + b.blank;
    return "";
}

std::string frame_text(const Comparison& comparison, std::int64_t frame) {
    char time[48];
    std::snprintf(time, sizeof time, "%.3f s",
                  static_cast<double>(frame - comparison.first) / comparison.fps.value());
    return "frame " + std::to_string(frame) + ", " + time;
}

}  // namespace dapple::judge
