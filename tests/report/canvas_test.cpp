#include "report/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace dapple::report {
namespace {

constexpr Color kBlack{0, 0, 0}, kWhite{255, 255, 255};

/// The pixels that differ from black: half-open, empty where there are none.
struct Box {
    int left = 1 << 20, top = 1 << 20, right = 0, bottom = 0;
};

Box ink(const Canvas& canvas) {
    Box box;
    for (int y = 0; y < canvas.height(); ++y) {
        for (int x = 0; x < canvas.width(); ++x) {
            if (canvas.at(x, y) == kBlack) continue;
            box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x + 1),
                   std::max(box.bottom, y + 1)};
        }
    }
    return box;
}

Canvas written(int size, const std::string& text) {
    Canvas canvas(400, 100);
    canvas.text(10, 20, size, kWhite, text);
    return canvas;
}

std::vector<std::uint8_t> bytes_of(const Canvas& canvas) {
    return {canvas.rgb().begin(), canvas.rgb().end()};
}

TEST(Canvas, FillsRectanglesAndCutsOffWhatLiesOutside) {
    Canvas canvas(4, 3, {1, 2, 3});
    canvas.fill(-2, 1, 4, 9, {200, 100, 50});
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 4; ++x) {
            EXPECT_EQ(canvas.at(x, y), (x < 2 && y >= 1 ? Color{200, 100, 50} : Color{1, 2, 3}))
                << x << " " << y;
        }
    }
    canvas.fill(4, 0, 3, 3, kWhite);
    canvas.fill(0, -5, 4, 5, kWhite);
    EXPECT_EQ(canvas.at(3, 0), (Color{1, 2, 3}));
}

TEST(Canvas, CopiesPicturesBitByBitAndCutsThemOff) {
    std::vector<std::uint8_t> picture(3 * 5 * 4);
    for (std::size_t i = 0; i < picture.size(); ++i) picture[i] = static_cast<std::uint8_t>(3 + 4 * i);
    for (const auto& [left, top] : {std::pair{1, 2}, {-2, -1}, {4, 3}, {-9, 0}, {0, 50}}) {
        Canvas canvas(7, 6, {9, 9, 9});
        canvas.blit(left, top, picture, 5, 4);
        for (int y = 0; y < 6; ++y) {
            for (int x = 0; x < 7; ++x) {
                const int px = x - left, py = y - top;
                const bool inside = px >= 0 && py >= 0 && px < 5 && py < 4;
                const std::size_t i = inside ? static_cast<std::size_t>(3 * (5 * py + px)) : 0;
                const Color wanted =
                    inside ? Color{picture[i], picture[i + 1], picture[i + 2]} : Color{9, 9, 9};
                EXPECT_EQ(canvas.at(x, y), wanted) << left << " " << top << ": " << x << " " << y;
            }
        }
    }
}

TEST(Canvas, ALineThroughCentresFillsExactlyItsPixels) {
    Canvas canvas(8, 5);
    canvas.line(1.5, 2.5, 5.5, 2.5, kWhite);
    for (int y = 0; y < 5; ++y) {
        // Round ends: the pixels beyond them are half a pixel's width away from the line's edge.
        for (int x = 0; x < 8; ++x) {
            EXPECT_EQ(canvas.at(x, y), (y == 2 && x >= 1 && x <= 5 ? kWhite : kBlack)) << x << " " << y;
        }
    }
}

TEST(Canvas, ALineBetweenCentresIsSharedByItsNeighbours) {
    Canvas canvas(5, 8);
    canvas.line(2, 0, 2, 8, kWhite);
    EXPECT_EQ(canvas.at(1, 4), (Color{128, 128, 128}));
    EXPECT_EQ(canvas.at(2, 4), (Color{128, 128, 128}));
    EXPECT_EQ(canvas.at(0, 4), kBlack);
    EXPECT_EQ(canvas.at(3, 4), kBlack);
    canvas.line(-50, -70, 900, 800, kWhite, 3);  // far outside: cut off, not crashed
}

TEST(Canvas, TextStaysInsideItsLineAndItsWidth) {
    for (const int size : {8, 12, 16, 24, 40}) {
        for (const std::string text : {"Sliced beams, frame 12", "ÅÇgjpqy|_", "0123456789.e-05", "AVAWATo"}) {
            const Box box = ink(written(size, text));
            const int width = text_width(size, text);
            EXPECT_GT(width, 0);
            // Outlines may overhang their advance by less than a pixel for the bearings of DejaVu Sans ("j").
            EXPECT_GE(box.left, 10 - size / 8) << size << text;
            EXPECT_LE(box.right, 10 + width + 1) << size << text;
            // The base line stands on a whole pixel, so that what fills the line may pass it by one.
            EXPECT_GE(box.top, 20 - 1) << size << text;
            EXPECT_LE(box.bottom, 20 + size + 1) << size << text;
            // It is not a speck in the corner either.
            EXPECT_GT(box.right - box.left, width * 8 / 10) << size << text;
        }
    }
}

TEST(Canvas, InkHasTheFontsProportions) {
    // DejaVu Sans in units of 2048 an em, with 2384 from ascender to descender: H is 1493 high and 1540
    // wide with its stems from 201 to 1339.
    const int size = 60;
    const double unit = size / 2384.0;
    const Box box = ink(written(size, "H"));
    EXPECT_NEAR(box.bottom - box.top, 1493 * unit, 1);  // the ends of anti-aliased edges
    EXPECT_NEAR(box.right - box.left, (1339 - 201) * unit, 1.5);
    EXPECT_NEAR(box.left, 10 + 201 * unit, 1);
    EXPECT_NEAR(box.bottom, 20 + 1901 * unit, 1);  // the base line
    EXPECT_NEAR(text_width(size, "H"), 1540 * unit, 1);
}

TEST(Canvas, TextGrowsEvenlyWithItsSize) {
    const std::string text = "sliced_beams";
    const double unit = text_width(400, text) / 400.0;
    for (int size = 8; size < 60; ++size) EXPECT_NEAR(text_width(size, text), size * unit, 1) << size;
}

TEST(Canvas, TextIsBlendedOverWhatIsThere) {
    Canvas canvas(100, 40, {10, 200, 60});
    canvas.text(5, 5, 30, {10, 200, 60}, "same colour");
    for (int x = 0; x < 100; ++x) EXPECT_EQ(canvas.at(x, 20), (Color{10, 200, 60}));
    bool between = false;
    Canvas other(100, 40);
    other.text(5, 5, 30, kWhite, "O");
    for (int x = 0; x < 100; ++x) between |= other.at(x, 20).red > 20 && other.at(x, 20).red < 235;
    EXPECT_TRUE(between) << "edges are anti-aliased";
}

TEST(Canvas, BrokenAndUnknownCharactersAreBoxes) {
    const Canvas unknown = written(20, "\U000F1234");
    EXPECT_GT(ink(unknown).right, 0);
    // One box for a byte that is no UTF-8, wherever it stands.
    for (const std::string text : {"\xff", "\x80", "\xc3", "\xed\xa0", "\xf5"}) {
        const int boxes = text == "\xed\xa0" ? 2 : 1;
        EXPECT_NEAR(text_width(200, text), boxes * text_width(200, "\U000F1234"), 1);
    }
    EXPECT_NE(bytes_of(written(20, "é")), bytes_of(unknown));
    EXPECT_EQ(text_width(20, ""), 0);
    EXPECT_EQ(text_width(0, "a"), 0);
    EXPECT_NE(bytes_of(written(20, "a")), bytes_of(written(20, "b")));
}

TEST(Canvas, LongTextKeepsItsEnd) {
    const std::string text = "renders/größe/sliced_beams";
    EXPECT_EQ(shortened(16, text, 1000), text);
    EXPECT_EQ(shortened(16, text, text_width(16, text)), text);
    for (int width = 20; width < text_width(16, text); width += 7) {
        const std::string cut = shortened(16, text, width);
        EXPECT_LE(text_width(16, cut), width);
        EXPECT_GT(text_width(16, cut), width - 16) << "a character more would have fitted";
        ASSERT_TRUE(cut.starts_with("\u2026"));
        EXPECT_TRUE(text.ends_with(cut.substr(3))) << cut;
        EXPECT_NE(static_cast<unsigned char>(cut[3]) & 0xC0, 0x80) << "half a character";
    }
    EXPECT_EQ(shortened(16, text, 3), "");
}

TEST(Canvas, TheSameBitsFromAnyThread) {
    const std::string text = "frame 0012  t = 0.458 s";
    const std::vector<std::uint8_t> wanted = bytes_of(written(17, text));
    std::vector<std::vector<std::uint8_t>> got(8);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < got.size(); ++i) {
        threads.emplace_back([&, i] {
            (void)written(9 + static_cast<int>(i), text);  // other sizes in between
            got[i] = bytes_of(written(17, text));
        });
    }
    for (std::thread& thread : threads) thread.join();
    for (const std::vector<std::uint8_t>& bytes : got) EXPECT_EQ(bytes, wanted);
}

}  // namespace
}  // namespace dapple::report
