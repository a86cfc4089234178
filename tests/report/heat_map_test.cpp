#include "report/heat_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dapple::report {
namespace {

/// CIE L* of an sRGB colour.
double lightness(Color color) {
    const auto linear = [](std::uint8_t code) {
        const double v = code / 255.0;
        return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    };
    const double y = 0.2126 * linear(color.red) + 0.7152 * linear(color.green) + 0.0722 * linear(color.blue);
    return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(HeatMap, LightnessGrowsEvenly) {
    const double end = lightness(heat(1));
    EXPECT_LT(lightness(heat(0)), 2);
    EXPECT_GT(end, 95);
    double before = lightness(heat(0));
    for (int i = 1; i <= 100; ++i) {
        const double now = lightness(heat(i / 100.0));
        // Codes of 8 bits and a table of 11 entries: small steps may stand still, none goes back.
        EXPECT_GT(now, before - 0.4) << i;
        EXPECT_NEAR(now, end * i / 100, 6) << i;
        before = now;
    }
}

TEST(HeatMap, HoldsTheEndsAndShowsNaN) {
    EXPECT_EQ(heat(-3), heat(0));
    EXPECT_EQ(heat(7), heat(1));
    EXPECT_EQ(heat(0.5), (Color{188, 55, 84}));
    EXPECT_EQ(heat(kNaN), (Color{255, 0, 255}));
    EXPECT_EQ(signed_heat(kNaN), (Color{255, 0, 255}));
    EXPECT_EQ(signed_heat(0), (Color{255, 255, 255}));
    EXPECT_EQ(signed_heat(-9), signed_heat(-1));
}

TEST(HeatMap, SignsDifferInHueNotInLightness) {
    for (int i = 1; i <= 20; ++i) {
        const Color below = signed_heat(-i / 20.0), above = signed_heat(i / 20.0);
        EXPECT_GT(below.blue, below.red) << i;
        EXPECT_GT(above.red, above.blue) << i;
        EXPECT_NEAR(lightness(below), lightness(above), 5) << i;  // well below what reads as an edge
    }
}

TEST(HeatMap, ValuesAreDividedByTheFixedScale) {
    const std::vector<float> values{0, 1, 2, 4, 8, -1};
    const std::vector<std::uint8_t> rgb = heat_map(values, 4);
    ASSERT_EQ(rgb.size(), 18u);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Color wanted = heat(values[i] / 4.0);
        EXPECT_EQ((Color{rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]}), wanted) << i;
    }
}

TEST(HeatMap, TheScaleIsDrawnInsideItsBoxFromDarkToBright) {
    Canvas canvas(300, 60, {40, 40, 40});
    draw_scale(canvas, 20, 10, 240, 30, 0.125, "|A - B| / clip mean");
    EXPECT_EQ(canvas.at(20, 11), heat(0.5 / 240));
    EXPECT_EQ(canvas.at(259, 11), heat(239.5 / 240));
    EXPECT_EQ(canvas.at(140, 15), heat(120.5 / 240));
    bool text = false;
    for (int y = 0; y < 60; ++y) {
        for (int x = 0; x < 300; ++x) {
            const bool inside = x >= 20 && x < 260 && y >= 10 && y < 40;
            if (!inside) {
                EXPECT_EQ(canvas.at(x, y), (Color{40, 40, 40})) << x << " " << y;
            }
            text |= y >= 20 && canvas.at(x, y).red > 150;
        }
    }
    EXPECT_TRUE(text);
}

TEST(ShortNumber, ThreeDigitsInTheShorterForm) {
    EXPECT_EQ(short_number(0), "0");
    EXPECT_EQ(short_number(-0.0), "0");
    EXPECT_EQ(short_number(1), "1");
    EXPECT_EQ(short_number(0.25), "0.25");
    EXPECT_EQ(short_number(-12.345), "-12.3");
    EXPECT_EQ(short_number(1234.5), "1230");
    EXPECT_EQ(short_number(99999), "1e+05");
    EXPECT_EQ(short_number(100), "100");
    EXPECT_EQ(short_number(0.0125), "0.0125");
    EXPECT_EQ(short_number(0.0000125), "1.25e-05");
    EXPECT_EQ(short_number(0.9996), "1");
    EXPECT_EQ(short_number(1e300), "1e+300");
    EXPECT_EQ(short_number(std::numeric_limits<double>::denorm_min()), "4.94e-324");
    EXPECT_EQ(short_number(kNaN), "nan");
    EXPECT_EQ(short_number(-std::numeric_limits<double>::infinity()), "-inf");
}

}  // namespace
}  // namespace dapple::report
