#include "report/plot.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>

#include "report/axis.h"
#include "report/canvas.h"
#include "report/heat_map.h"
#include "report/html_page.h"
#include "report/ticks.h"

namespace dapple::report {
namespace {

constexpr int kText = 14;   // px from line to line
constexpr int kTitle = 17;  // px
constexpr const char* kGrid = "stroke=\"#d9dce1\"";
constexpr const char* kFineGrid = "stroke=\"#eff1f4\"";
constexpr const char* kFont = "font-family=\"'DejaVu Sans',Verdana,sans-serif\"";

/// Colours that stay apart for weak colour sight and in print, after M. Okabe and K. Ito; when they are used
/// up they come again with dashed lines.
constexpr std::array<const char*, 7> kColors{"#0072b2", "#d55e00", "#009e73", "#b5508f",
                                             "#c08a00", "#3a9bd4", "#222222"};
constexpr std::array<const char*, 4> kDashes{"", "7 4", "2 3", "9 3 2 3"};

/// Hundredths of a pixel, always with a point.
std::string px(double value) {
    char text[64];
    return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 2).ptr};
}

std::string text_element(double x, double y, const char* anchor, const std::string& text,
                         const std::string& more = "") {
    return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escaped(text) + "</text>\n";
}

std::string line_element(double x0, double y0, double x1, double y1, const std::string& style) {
    return "<line x1=\"" + px(x0) + "\" y1=\"" + px(y0) + "\" x2=\"" + px(x1) + "\" y2=\"" + px(y1) + "\" " +
           style + "/>\n";
}

std::string pen(std::size_t series) {
    const char* dash = kDashes[series / kColors.size() % kDashes.size()];
    std::string style = std::string("fill=\"none\" stroke=\"") + kColors[series % kColors.size()] +
                        "\" stroke-width=\"1.75\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
    if (*dash != '\0') style += std::string(" stroke-dasharray=\"") + dash + "\"";
    return style;
}

/// A circle, square, diamond or triangle: series differ without colour too.
std::string mark(std::size_t series, double x, double y, const std::string& tip) {
    const std::string shape = [&] {
        switch (series % 4) {
            case 0:
                return "M" + px(x - 3.5) + " " + px(y) + "a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0z";
            case 1:
                return "M" + px(x - 3.2) + " " + px(y - 3.2) + "h6.4v6.4h-6.4z";
            case 2:
                return "M" + px(x) + " " + px(y - 4.5) + "l4.5 4.5l-4.5 4.5l-4.5 -4.5z";
            default:
                return "M" + px(x) + " " + px(y - 4.2) + "l4.2 7.4h-8.4z";
        }
    }();
    return "<path d=\"" + shape + "\" fill=\"" + kColors[series % kColors.size()] + "\">" +
           (tip.empty() ? "" : "<title>" + escaped(tip) + "</title>") + "</path>\n";
}

/// Names with their pens in rows below the title. Returns what they take in height.
int legend(const Plot& plot, int top, std::string& out) {
    constexpr int kSample = 26, kGap = 18;
    int x = 0, y = top;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        const Series& series = plot.series[i];
        if (series.name.empty()) continue;
        const int width = kSample + 6 + text_width(kText, series.name);
        if (x > 0 && x + width > plot.width - 20) x = 0, y += kText + 6;
        const double middle = y + kText / 2.0 + 1;
        if (series.line) out += line_element(10 + x, middle, 10 + x + kSample, middle, pen(i));
        if (series.marks) out += mark(i, 10 + x + kSample / 2.0, middle, "");
        out += text_element(10 + x + kSample + 6, y + kText - 2, "start", series.name);
        x += width + kGap;
    }
    return x == 0 && y == top ? 0 : y + kText + 8 - top;
}

void draw_series(const Series& series, std::size_t number, const Axis& x, const Axis& y, std::string& out) {
    // What cannot be shown is a gap in the line, not a straight way across. The first after a gap is a dot,
    // so that one alone can be seen.
    std::string path;
    bool drawn = false;
    for (const auto& [at, value] : series.points) {
        const bool shown = x.shows(at) && y.shows(value);
        if (shown) path += (drawn ? "L" : "M") + px(x(at)) + " " + px(y(value)) + (drawn ? "" : "h0");
        drawn = shown;
    }
    if (series.line && !path.empty()) out += "<path d=\"" + path + "\" " + pen(number) + "/>\n";
    if (!series.marks) return;
    for (const auto& [at, value] : series.points) {
        if (!x.shows(at) || !y.shows(value)) continue;
        const std::string name = series.name.empty() ? "" : series.name + ": ";
        out += mark(number, x(at), y(value), name + short_number(at) + ", " + short_number(value));
    }
}

int most_y_ticks(int top, int bottom) {
    return std::max(2, (bottom - top) / 30);
}

/// Grid, ticks and their numbers, frame and labels of axes that have been placed.
std::string axes(const Plot& plot, const Axis& x, const Axis& y, int left, int top, int right, int bottom) {
    std::string out;
    for (const double tick : x.fine_ticks()) out += line_element(x(tick), top, x(tick), bottom, kFineGrid);
    for (const double tick : y.fine_ticks()) out += line_element(left, y(tick), right, y(tick), kFineGrid);
    const std::vector<double> x_ticks = x.ticks(std::max(2, (right - left) / 80));
    const std::vector<std::string> x_labels = tick_labels(x_ticks);
    for (std::size_t i = 0; i < x_ticks.size(); ++i) {
        const double at = x(x_ticks[i]);
        out += line_element(at, top, at, bottom, kGrid);
        out += text_element(at, bottom + kText + 3, "middle", x_labels[i]);
    }
    const std::vector<double> y_ticks = y.ticks(most_y_ticks(top, bottom));
    const std::vector<std::string> y_labels = tick_labels(y_ticks);
    for (std::size_t i = 0; i < y_ticks.size(); ++i) {
        const double at = y(y_ticks[i]);
        out += line_element(left, at, right, at, kGrid);
        out += text_element(left - 6, at + 4, "end", y_labels[i]);
    }
    out += "<rect x=\"" + px(left) + "\" y=\"" + px(top) + "\" width=\"" + px(right - left) + "\" height=\"" +
           px(bottom - top) + "\" fill=\"none\" stroke=\"#7d848e\"/>\n";
    out += text_element((left + right) / 2.0, bottom + 2 * kText + 8, "middle", plot.x_label);
    const double middle = (top + bottom) / 2.0;
    out +=
        text_element(14, middle, "middle", plot.y_label, " transform=\"rotate(-90 14 " + px(middle) + ")\"");
    return out;
}

}  // namespace

std::string svg(const Plot& plot) {
    std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(plot.width) +
                      "\" height=\"" + std::to_string(plot.height) + "\" viewBox=\"0 0 " +
                      std::to_string(plot.width) + " " + std::to_string(plot.height) + "\" role=\"img\" " +
                      kFont + " font-size=\"12\" fill=\"#1d1f23\">\n<title>" + escaped(plot.title) +
                      "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
    int top = 6;
    if (!plot.title.empty()) {
        out +=
            text_element(10, top + kTitle - 4, "start", plot.title, " font-size=\"14\" font-weight=\"bold\"");
        top += kTitle + 5;
    }
    top += legend(plot, top, out) + 4;

    Axis x(plot.log_x), y(plot.log_y);
    for (const Series& series : plot.series) {
        for (const auto& [at, value] : series.points) {
            if (!x.shows(at)) continue;
            x.include(at);  // gaps too, so that plots of one clip are alike
            if (y.shows(value)) y.include(value);
        }
    }
    if (y.empty()) {
        out +=
            text_element(plot.width / 2.0, (top + plot.height) / 2.0, "middle", "there is nothing to show");
        return out + "</svg>\n";
    }
    for (const auto& [level, name] : plot.limits) {
        if (y.shows(level)) y.include(level);
    }
    x.finish(plot.log_x ? 0.04 : 0.02, Axis::Start::values);
    y.finish(0.06, Axis::Start::zero);

    const int bottom = plot.height - 2 * kText - 16, right = plot.width - 16;
    int widest = 0;
    for (const std::string& label : tick_labels(y.ticks(most_y_ticks(top, bottom)))) {
        widest = std::max(widest, text_width(kText, label));
    }
    const int left = widest + 34;
    x.place(left, right);
    y.place(bottom, top);

    out += axes(plot, x, y, left, top, right, bottom);
    for (const auto& [level, name] : plot.limits) {
        if (!y.shows(level)) continue;
        out += line_element(left, y(level), right, y(level),
                            "stroke=\"#b3261e\" stroke-width=\"1.25\" stroke-dasharray=\"6 3\"");
        // Above the line, but inside of the frame.
        const double base = y(level) - 4 < top + kText ? y(level) + kText : y(level) - 4;
        out += text_element(right - 6, base, "end", name, " fill=\"#b3261e\"");
    }
    for (std::size_t i = 0; i < plot.series.size(); ++i) draw_series(plot.series[i], i, x, y, out);
    return out + "</svg>\n";
}

}  // namespace dapple::report
