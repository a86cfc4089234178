#include "report/canvas_plot.h"

#include <gtest/gtest.h>

#include <limits>

namespace dapple::report {
namespace {

constexpr Color kGround{20, 20, 24}, kRed{255, 0, 0};

/// Pixels that are rather red than grey: lines are anti-aliased.
int reddish(const Canvas& canvas) {
    int count = 0;
    for (int y = 0; y < canvas.height(); ++y) {
        for (int x = 0; x < canvas.width(); ++x) count += canvas.at(x, y).red > canvas.at(x, y).green + 60;
    }
    return count;
}

int count_of(const Canvas& canvas, Color color) {
    int count = 0;
    for (int y = 0; y < canvas.height(); ++y) {
        for (int x = 0; x < canvas.width(); ++x) count += canvas.at(x, y) == color;
    }
    return count;
}

TEST(CanvasPlot, DrawsOnlyInsideItsBox) {
    Canvas canvas(300, 200, kGround);
    const Plot plot{.series = {{"a", {{1, 0.5}, {2, 3}, {50, 2}}}}};
    const CanvasPlot drawn(plot, {kRed}, 40, 30, 220, 120);
    drawn.draw(canvas);
    drawn.draw_cursor(canvas, 25);
    drawn.draw_cursor(canvas, 900);
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 300; ++x) {
            if (x >= 40 && x < 260 && y >= 30 && y < 150) continue;
            ASSERT_EQ(canvas.at(x, y), kGround) << x << " " << y;
        }
    }
    EXPECT_GT(reddish(canvas), 100);
}

TEST(CanvasPlot, GapsAreGapsAndALonePointIsADot) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Canvas whole(300, 200, kGround), gap(300, 200, kGround), dot(300, 200, kGround);
    CanvasPlot({.series = {{"", {{0, 1}, {1, 1}, {2, 1}}}}}, {kRed}, 0, 0, 300, 200).draw(whole);
    CanvasPlot({.series = {{"", {{0, 1}, {1, nan}, {2, 1}}}}}, {kRed}, 0, 0, 300, 200).draw(gap);
    CanvasPlot({.series = {{"", {{0, 1}, {2, nan}}}}}, {kRed}, 0, 0, 300, 200).draw(dot);
    EXPECT_GT(reddish(whole), 100);
    EXPECT_LT(reddish(gap), 40);
    EXPECT_GT(reddish(gap), reddish(dot));
    EXPECT_GT(reddish(dot), 0);
}

TEST(CanvasPlot, WithoutAPointItSaysSo) {
    Canvas canvas(300, 200, kGround);
    CanvasPlot plot({.series = {{"a", {}}}}, {kRed}, 0, 0, 300, 200);
    plot.draw(canvas);
    EXPECT_LT(count_of(canvas, kGround), 300 * 200);
    const int before = count_of(canvas, kGround);
    plot.draw_cursor(canvas, 3);
    EXPECT_EQ(count_of(canvas, kGround), before);
}

}  // namespace
}  // namespace dapple::report
