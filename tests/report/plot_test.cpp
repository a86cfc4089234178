#include "report/plot.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "report/ticks.h"

namespace dapple::report {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

/// The path of the only line of a plot; the legend's sample comes before it.
std::string path_of(const std::string& text) {
    const std::size_t end = text.rfind("\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"1.75\"");
    const std::size_t begin = text.rfind("d=\"", end) + 3;
    return text.substr(begin, end - begin);
}

TEST(Ticks, LinearOnesAreRoundAndExact) {
    EXPECT_THAT(linear_ticks({0, 1}, 6), ElementsAre(0, 0.2, 0.4, 0.6, 0.8, 1));
    EXPECT_THAT(linear_ticks({0, 1}, 5), ElementsAre(0, 0.5, 1));
    EXPECT_THAT(linear_ticks({-3, 12}, 8), ElementsAre(-2, 0, 2, 4, 6, 8, 10, 12));
    EXPECT_THAT(linear_ticks({0.31, 0.42}, 3), ElementsAre(0.35, 0.4));
    EXPECT_THAT(linear_ticks({1000, 1000.5}, 3), ElementsAre(1000, 1000.2, 1000.4));
}

TEST(Ticks, LinearOnesLieInTheRangeAndAreEnough) {
    for (double low : {-7.3e5, -0.01, 0.0, 3.1e-9, 12.0}) {
        for (double extent : {1e-3, 0.7, 1.0, 33.0, 9.9e6}) {
            for (int most : {2, 5, 9}) {
                const std::vector<double> ticks = linear_ticks({low, low + extent}, most);
                EXPECT_LE(ticks.size(), static_cast<std::size_t>(most));
                // The steps grow by 2.5 at most, so a third of what is allowed is there, but for the ends.
                EXPECT_GE(ticks.size() + 1, static_cast<std::size_t>(most) / 3) << low << " " << extent;
                for (const double tick : ticks) {
                    EXPECT_GE(tick, low - 1e-8 * extent);
                    EXPECT_LE(tick, low + extent + 1e-8 * extent);
                }
            }
        }
    }
}

TEST(Ticks, LogarithmicOnesAreDecadesOrFiner) {
    EXPECT_THAT(log_ticks({0.01, 100}, 9), ElementsAre(0.01, 0.1, 1, 10, 100));
    EXPECT_THAT(log_ticks({1e-6, 1e6}, 5), ElementsAre(1e-6, 1e-3, 1, 1e3, 1e6));
    EXPECT_THAT(log_ticks({0.9, 25}, 9), ElementsAre(1, 2, 5, 10, 20));
    EXPECT_THAT(log_ticks({2.2, 2.9}, 4), ElementsAre(2.2, 2.4, 2.6, 2.8));
}

TEST(Ticks, LabelsHaveTheDigitsThatTellThemApart) {
    EXPECT_THAT(tick_labels({0, 0.2, 0.4}), ElementsAre("0", "0.2", "0.4"));
    EXPECT_THAT(tick_labels({0.3405, 0.341, 0.3415}), ElementsAre("0.3405", "0.341", "0.3415"));
    EXPECT_THAT(tick_labels({1000, 1001, 1002}), ElementsAre("1000", "1001", "1002"));
    EXPECT_THAT(tick_labels({1e-6, 1e-3, 1, 1e6}), ElementsAre("1e-06", "0.001", "1", "1e+06"));
    EXPECT_THAT(tick_labels({-10.00002, -10}), ElementsAre("-10.00002", "-10"));
}

TEST(Plot, PointsStandWhereTheAxesSay) {
    Plot plot{.title = "t",
              .x_label = "frame",
              .y_label = "value",
              .series = {{"a", {{0, 0}, {5, 50}, {10, 100}}}}};
    const std::string text = svg(plot);
    double x[3] = {}, y[3] = {};
    ASSERT_EQ(std::sscanf(path_of(text).c_str(), "M%lf %lfh0L%lf %lfL%lf %lf", &x[0], &y[0], &x[1], &y[1],
                          &x[2], &y[2]),
              6);
    // Values are printed in hundredths of a pixel.
    EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.021);
    EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.021);
    EXPECT_LT(y[2], y[0]);
    for (const char* number : {">0<", ">20<", ">40<", ">10<", ">frame<", ">value<", ">a<"})
        EXPECT_THAT(text, HasSubstr(number));
}

TEST(Plot, DecadesAreEquallyFarApart) {
    Plot plot{.log_x = true, .log_y = true, .series = {{"", {{1, 1e-3}, {10, 1e-2}, {100, 1e-1}}}}};
    double x[3] = {}, y[3] = {};
    ASSERT_EQ(std::sscanf(path_of(svg(plot)).c_str(), "M%lf %lfh0L%lf %lfL%lf %lf", &x[0], &y[0], &x[1],
                          &y[1], &x[2], &y[2]),
              6);
    EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.021);
    EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.021);
}

TEST(Plot, WhatCannotBeShownIsAGap) {
    Plot plot{.series = {{"", {{0, 1}, {1, kNaN}, {2, 3}, {3, 2}}}}};
    EXPECT_EQ(count(path_of(svg(plot)), "M"), 2u);
    EXPECT_EQ(count(path_of(svg(plot)), "L"), 1u);
    plot.log_y = true;
    plot.series = {{"", {{0, 1}, {1, 2}, {2, 0}, {3, 2}, {4, -1}}, true, true}};
    EXPECT_EQ(count(path_of(svg(plot)), "M"), 2u);
    EXPECT_EQ(count(svg(plot), "<title>") - 1, 3u) << "marks have the values as tips, the plot its title";
}

TEST(Plot, WithoutAPointItSaysSo) {
    EXPECT_THAT(svg({.title = "empty"}), HasSubstr("nothing to show"));
    Plot plot{.log_y = true, .series = {{"a", {{0, 0}, {1, kNaN}}}}};
    EXPECT_THAT(svg(plot), HasSubstr("nothing to show"));
}

TEST(Plot, OneValueAndNearlyOneHaveAxesToo) {
    for (const double value : {0.0, 1.0, -4e-7, 1e9}) {
        for (const double more : {0.0, 1e-16, 1e-12}) {
            Plot plot{.series = {{"a", {{3, value}, {3, value * (1 + more)}}}}};
            const std::string text = svg(plot);
            EXPECT_THAT(text, Not(HasSubstr("nan")));
            EXPECT_THAT(text, Not(HasSubstr("inf")));
            plot.log_x = true;
            EXPECT_THAT(svg(plot), HasSubstr("</svg>"));
        }
    }
}

TEST(Plot, LevelsAreShownEvenAboveAllPoints) {
    Plot plot{.series = {{"", {{0, 1}, {1, 2}}}}, .limits = {{40, "limit <40>"}}};
    const std::string text = svg(plot);
    EXPECT_THAT(text, HasSubstr("limit &lt;40&gt;"));
    EXPECT_THAT(text, HasSubstr(">40<"));  // the axis reaches it
}

TEST(Plot, TextIsEscapedAndTheSameEachTime) {
    Plot plot{.title = "<b>&\"'",
              .x_label = "<x>",
              .y_label = "<y>",
              .series = {{"<s>", {{0, 1}, {1, 2}}, true, true}}};
    const std::string text = svg(plot);
    for (const char* raw : {"<b>", "<x>", "<y>", "<s>"}) EXPECT_THAT(text, Not(HasSubstr(raw)));
    EXPECT_EQ(text, svg(plot));
}

}  // namespace
}  // namespace dapple::report
