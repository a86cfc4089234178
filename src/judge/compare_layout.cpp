#include "judge/compare_layout.h"

#include <algorithm>
#include <string>

#include "base/error.h"

namespace dapple::judge {
namespace {

constexpr int kGap = 16;                                // between panels and around them
constexpr int kHeader = 30;                             // the line on top
constexpr int kCaption = 28;                            // over a panel
constexpr int kFooter = 30;                             // under wipe and differences
constexpr int kPlot = 190;                              // height of the plots
constexpr int kTiny = 480;                              // pictures are enlarged up to it, by whole factors
constexpr int kNarrowest = 300;                         // of a column, for captions
constexpr int kThickestFrame = 16;                      // rows of one frame in a slice
constexpr double kPlainWidth = 640, kLargestScale = 4;  // text grows where columns are wider
constexpr int kLargest = 16384;                         // pixels each way that encoders of H.264 take

/// Columns of equal width, filled from the left, and rows from the top.
class Grid {
public:
    Grid(int columns, int picture_width)
        : picture_width_(picture_width),
          column_width_(std::max(picture_width, kNarrowest)),
          scale_(std::clamp(column_width_ / kPlainWidth, 1.0, kLargestScale)) {
        width_ = kGap + columns * (column_width_ + kGap);
    }
    int width() const { return width_; }
    int bottom() const { return y_; }
    /// Heights of lines of text grow with the pictures: a large video is looked at from afar, or made small.
    int scaled(int height) const { return static_cast<int>(height * scale_); }
    Box header() {
        const Box box{kGap, y_, width_ - 2 * kGap, scaled(kHeader)};
        y_ += scaled(kHeader) + kGap / 2;
        return box;
    }
    /// In the current row. Pictures stand in the middle of their columns.
    Panel panel(int column, int height, int footer) const {
        const int x = kGap + column * (column_width_ + kGap), caption = scaled(kCaption);
        return {{x + (column_width_ - picture_width_) / 2, y_ + caption, picture_width_, height},
                {x, y_, column_width_, caption},
                {x, y_ + caption + height, column_width_, footer}};
    }
    /// Half of the whole width.
    Panel half(int which, int height) const {
        const int half = (width_ - 3 * kGap) / 2, x = kGap + which * (half + kGap),
                  caption = scaled(kCaption);
        return {{x, y_ + caption, half, height}, {x, y_, half, caption}, {}};
    }
    void next_row(int height, int footer) { y_ += scaled(kCaption) + height + footer + kGap; }

private:
    int picture_width_, column_width_;
    double scale_;
    int width_;
    int y_ = kGap / 2;
};

void check_size(const Layout& layout) {
    if (layout.width <= kLargest && layout.height <= kLargest) return;
    throw Error(ExitCode::usage, "the video would have " + std::to_string(layout.width) + " x " +
                                     std::to_string(layout.height) + " pixels, and H.264 takes " +
                                     std::to_string(kLargest) + " each way: leave parts out by --parts");
}

}  // namespace

Layout plan_layout(int width, int height, std::size_t sequences, std::size_t frames,
                   const CompareParts& parts) {
    const int columns = static_cast<int>(sequences), count = static_cast<int>(frames);
    Layout layout;
    layout.factor = std::max(1, kTiny / std::max(width, height));
    const int shown_height = height * layout.factor;
    Grid grid(columns, width * layout.factor);
    layout.width = grid.width();
    layout.header = grid.header();
    if (parts.side) {
        for (int i = 0; i < columns; ++i) layout.sides.push_back(grid.panel(i, shown_height, 0));
        grid.next_row(shown_height, 0);
    }
    if (parts.wipe || parts.difference) {
        int column = 0;
        if (parts.wipe) layout.wipe = grid.panel(column++, shown_height, grid.scaled(kFooter));
        for (int i = 1; parts.difference && i < columns; ++i) {
            layout.differences.push_back(grid.panel(column++, shown_height, grid.scaled(kFooter)));
        }
        grid.next_row(shown_height, grid.scaled(kFooter));
    }
    if (parts.slice) {
        // All frames in half the height of a picture, if they fit; else at most a picture of them, one row
        // each.
        layout.slice_rows = std::clamp(shown_height / 2 / count, 1, kThickestFrame);
        layout.slice_frames = std::min(count, std::max(shown_height / layout.slice_rows, 1));
        const int slice_height = layout.slice_frames * layout.slice_rows;
        for (int i = 0; i < columns; ++i) layout.slices.push_back(grid.panel(i, slice_height, 0));
        grid.next_row(slice_height, 0);
    }
    if (parts.flicker) {
        layout.mean_plot = grid.half(0, grid.scaled(kPlot));
        layout.flicker_plot = grid.half(1, grid.scaled(kPlot));
        grid.next_row(grid.scaled(kPlot), 0);
    }
    layout.height = grid.bottom();
    check_size(layout);
    return layout;
}

}  // namespace dapple::judge
