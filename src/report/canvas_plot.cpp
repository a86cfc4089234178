#include "report/canvas_plot.h"

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

#include "report/ticks.h"

namespace dapple::report {
namespace {

constexpr Color kFrame{110, 112, 120}, kGrid{58, 59, 66}, kNumbers{176, 178, 186}, kCursor{255, 255, 255};
constexpr double kLine = 1.6 / 14, kDot = 3.0 / 14;  // widths, in heights of text

}  // namespace

CanvasPlot::CanvasPlot(Plot plot, std::vector<Color> colors, int x, int y, int width, int height, int text)
    : plot_(std::move(plot)), colors_(std::move(colors)), x_(plot_.log_x), y_(plot_.log_y), text_(text) {
    assert(colors_.size() >= plot_.series.size());
    for (const Series& series : plot_.series) {
        for (const auto& [at, value] : series.points) {
            if (!x_.shows(at)) continue;
            x_.include(at);  // gaps too, so that plots of one clip are alike
            if (y_.shows(value)) y_.include(value);
        }
    }
    top_ = y + text_ / 2;
    bottom_ = y + height - text_ - 4;
    right_ = x + width - 1 - text_;  // the last number may stand beyond the frame
    left_ = x + text_;
    if (y_.empty()) return;
    x_.finish(0.02, Axis::Start::values);
    y_.finish(0.08, Axis::Start::zero);
    int widest = 0;
    for (const std::string& label : tick_labels(y_.ticks(most_y_ticks()))) {
        widest = std::max(widest, text_width(text_, label));
    }
    left_ = x + widest + 8;
    x_.place(left_, right_);
    y_.place(bottom_, top_);
}

int CanvasPlot::most_y_ticks() const {
    return std::max(2, (bottom_ - top_) / (2 * text_));
}

void CanvasPlot::draw(Canvas& canvas) const {
    if (y_.empty()) {
        const std::string text = "there is nothing to show";
        canvas.text((left_ + right_ - text_width(text_, text)) / 2, (top_ + bottom_ - text_) / 2, text_,
                    kNumbers, text);
        return;
    }
    const std::vector<double> x_ticks = x_.ticks(std::max(2, (right_ - left_) / (5 * text_)));
    const std::vector<std::string> x_labels = tick_labels(x_ticks);
    for (std::size_t i = 0; i < x_ticks.size(); ++i) {
        const double at = x_(x_ticks[i]);
        canvas.line(at, top_, at, bottom_, kGrid);
        canvas.text(static_cast<int>(at) - text_width(text_, x_labels[i]) / 2, bottom_ + 4, text_, kNumbers,
                    x_labels[i]);
    }
    const std::vector<double> y_ticks = y_.ticks(most_y_ticks());
    const std::vector<std::string> y_labels = tick_labels(y_ticks);
    for (std::size_t i = 0; i < y_ticks.size(); ++i) {
        const double at = y_(y_ticks[i]);
        canvas.line(left_, at, right_, at, kGrid);
        canvas.text(left_ - 6 - text_width(text_, y_labels[i]), static_cast<int>(at) - text_ / 2, text_,
                    kNumbers, y_labels[i]);
    }
    canvas.fill(left_, top_, right_ - left_ + 1, 1, kFrame);
    canvas.fill(left_, bottom_, right_ - left_ + 1, 1, kFrame);
    canvas.fill(left_, top_, 1, bottom_ - top_ + 1, kFrame);
    canvas.fill(right_, top_, 1, bottom_ - top_ + 1, kFrame);
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
        const std::pair<double, double>* before = nullptr;
        for (const auto& point : plot_.series[i].points) {
            if (!x_.shows(point.first) || !y_.shows(point.second)) {
                before = nullptr;
                continue;
            }
            // The first after a gap is a dot, so that one alone can be seen.
            const auto& from = before != nullptr ? *before : point;
            canvas.line(x_(from.first), y_(from.second), x_(point.first), y_(point.second), colors_[i],
                        text_ * (before != nullptr ? kLine : kDot));
            before = &point;
        }
    }
}

void CanvasPlot::draw_cursor(Canvas& canvas, double at) const {
    if (y_.empty() || !x_.shows(at)) return;
    const double x = std::clamp(x_(at), static_cast<double>(left_), static_cast<double>(right_));
    canvas.line(x, top_, x, bottom_, kCursor);
}

}  // namespace dapple::report
