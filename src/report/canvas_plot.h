#pragma once
#include <vector>

#include "report/axis.h"
#include "report/canvas.h"
#include "report/plot.h"

namespace dapple::report {

/// A plot on the dark ground of a canvas, for videos: the frame, ticks with their numbers, and the lines. Of
/// `Plot`, title, labels, limits, marks and size are not used: the caller writes captions.
class CanvasPlot {
public:
    /// The box is for everything; `colors` are those of the series; numbers are `text` pixels from line to
    /// line.
    CanvasPlot(Plot plot, std::vector<Color> colors, int x, int y, int width, int height, int text = 14);

    void draw(Canvas& canvas) const;
    /// An upright line at a value of x.
    void draw_cursor(Canvas& canvas, double at) const;

private:
    int most_y_ticks() const;

    Plot plot_;
    std::vector<Color> colors_;
    Axis x_, y_;
    int text_;
    int left_, top_, right_, bottom_;
};

}  // namespace dapple::report
