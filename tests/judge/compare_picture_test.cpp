// What is drawn, pixel by pixel, before any encoder sees it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "judge/compare_composer.h"
#include "judge/compare_drawing.h"
#include "judge/compare_scene.h"
#include "judge/compare_sheet.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

using testing_tools::ScratchFolder;

report::Color pixel(const std::vector<std::uint8_t>& rgb, int width, int x, int y) {
    const auto i = static_cast<std::size_t>(3 * (y * width + x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

glm::vec3 shifted(int x, int y, int frame) {
    return busy(x + 3, y, frame);
}

class ComparePictureTest : public testing::Test {
protected:
    ComparePictureTest() {
        a = write_clip(folder, "a", kWidth, kHeight, {1, 2, 3, 4, 5, 6, 7, 8}, busy);
        b = write_clip(folder, "b", kWidth, kHeight, {1, 2, 3, 4, 6, 7, 8}, shifted);
        c = write_clip(folder, "c", kWidth, kHeight, {1, 2, 3, 4, 5, 6, 7, 8},
                       [](int x, int y, int frame) { return 0.5f * busy(y, x, frame); });
    }
    /// Tiny and odd: enlarged by 480 / 97 = 4.
    static constexpr int kWidth = 97, kHeight = 53, kFactor = 4;
    ScratchFolder folder;
    std::string a, b, c;
};

TEST_F(ComparePictureTest, PicturesAreTheGradedSourcesBitByBit) {
    const Prepared prepared({.sequences = {a, b}});
    ASSERT_EQ(prepared.layout.factor, kFactor);
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const std::vector<ComparedPicture> pictures = prepared.pictures(2);
    const report::Canvas canvas = composer.compose(2, pictures);
    for (std::size_t i = 0; i < 2; ++i) {
        const Box& box = prepared.layout.sides[i].box;
        ASSERT_EQ(box.width, kWidth * kFactor);
        for (int y = 0; y < box.height; ++y) {
            for (int x = 0; x < box.width; ++x) {
                ASSERT_EQ(canvas.at(box.x + x, box.y + y),
                          pixel(pictures[i].rgb, kWidth, x / kFactor, y / kFactor));
            }
        }
    }
}

TEST_F(ComparePictureTest, TheWipeIsALeftOfItsDividerAndBRightOfIt) {
    const Prepared prepared({.sequences = {a, b}});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const Box& box = prepared.layout.wipe.box;
    std::set<int> dividers;
    for (std::size_t index = 0; index < prepared.comparison.frames.size(); ++index) {
        if (prepared.comparison.frames[index] == 5) continue;  // B has none
        const std::vector<ComparedPicture> pictures = prepared.pictures(index);
        const report::Canvas canvas = composer.compose(index, pictures);
        const int divider = composer.wipe_at(index).divider;
        dividers.insert(divider);
        for (int y = 0; y < box.height; ++y) {
            for (int x = 0; x < box.width; ++x) {
                const report::Color seen = canvas.at(box.x + x, box.y + y);
                if (x < divider - 1) {
                    ASSERT_EQ(seen, pixel(pictures[0].rgb, kWidth, x / kFactor, y / kFactor)) << x;
                } else if (x > divider) {
                    ASSERT_EQ(seen, pixel(pictures[1].rgb, kWidth, x / kFactor, y / kFactor)) << x;
                } else {
                    ASSERT_EQ(seen, (report::Color{255, 255, 255})) << x;
                }
            }
        }
    }
    EXPECT_TRUE(dividers.contains(box.width / 2));
    EXPECT_TRUE(dividers.contains(box.width)) << "it reaches the right end";
    EXPECT_TRUE(dividers.contains(0)) << "and the left one";
}

TEST_F(ComparePictureTest, TheWipeTakesTheOthersInTurn) {
    const Prepared prepared({.sequences = {a, b, c}});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    for (std::size_t index = 0; index < 8; ++index) {
        EXPECT_EQ(composer.wipe_at(index).sequence, index < 4 ? 1u : 2u) << index;
    }
    EXPECT_EQ(composer.wipe_at(4).divider, composer.wipe_at(0).divider);
    const std::vector<ComparedPicture> pictures = prepared.pictures(7);
    const report::Canvas canvas = composer.compose(7, pictures);
    const Box& box = prepared.layout.wipe.box;
    EXPECT_EQ(canvas.at(box.x + box.width - 1, box.y), pixel(pictures[2].rgb, kWidth, kWidth - 1, 0));
}

TEST_F(ComparePictureTest, DifferencesAreOnTheFixedScale) {
    const Prepared prepared({.sequences = {a, b, c}, .difference_scale = 0.8});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const std::vector<ComparedPicture> pictures = prepared.pictures(1);
    const report::Canvas canvas = composer.compose(1, pictures);
    for (std::size_t i = 1; i < 3; ++i) {
        const Box& box = prepared.layout.differences[i - 1].box;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                const auto p = static_cast<std::size_t>(y * kWidth + x);
                const double wanted = std::abs(static_cast<double>(pictures[0].light.luminance[p]) -
                                               pictures[i].light.luminance[p]) /
                                      prepared.found.sequences[0].clip.mean / 0.8;
                const report::Color seen = canvas.at(box.x + x * kFactor, box.y + y * kFactor);
                // A code is left for the rounding of the difference to float.
                ASSERT_NEAR(seen.red, report::heat(wanted).red, 1);
                ASSERT_NEAR(seen.green, report::heat(wanted).green, 1);
                ASSERT_NEAR(seen.blue, report::heat(wanted).blue, 1);
            }
        }
    }
}

TEST_F(ComparePictureTest, SlicesAreTheRowOfEveryFrame) {
    const Prepared prepared({.sequences = {a, b}, .slice_row = 11});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const report::Canvas canvas = composer.compose(0, prepared.pictures(0));
    ASSERT_EQ(prepared.layout.slice_frames, 8);
    for (std::size_t i = 0; i < 2; ++i) {
        const Box& box = prepared.layout.slices[i].box;
        for (int t = 0; t < 8; ++t) {
            const std::vector<ComparedPicture> pictures = prepared.pictures(static_cast<std::size_t>(t));
            for (int x = 0; x < box.width; ++x) {
                for (int copy = 0; copy < prepared.layout.slice_rows; ++copy) {
                    const report::Color wanted =
                        pictures[i].rgb.empty() ? kBlank : pixel(pictures[i].rgb, kWidth, x / kFactor, 11);
                    ASSERT_EQ(canvas.at(box.x + x, box.y + t * prepared.layout.slice_rows + copy), wanted)
                        << i << " " << t << " " << x;
                }
            }
        }
    }
}

TEST_F(ComparePictureTest, ALongClipsSlicesFollowTheFrame) {
    // 60 frames of 20 rows: at most 20 of them are seen, enlarged pictures having 20 * 12 = 240 rows... so
    // tall and narrow instead, where a picture's half is less than the clip.
    std::vector<int> frames;
    for (int frame = 1; frame <= 40; ++frame) frames.push_back(frame);
    const std::string still = write_clip(folder, "long", 480, 12, frames, [](int, int, int frame) {
        return glm::vec3(0.01f * static_cast<float>(frame));
    });
    const Prepared prepared({.sequences = {still, still}, .labels = {"one", "two"}});
    ASSERT_EQ(prepared.layout.slice_rows, 1);
    ASSERT_EQ(prepared.layout.slice_frames, 12);
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const Box& box = prepared.layout.slices[1].box;
    for (const auto& [index, first] : {std::pair{0, 0}, {6, 0}, {7, 1}, {20, 14}, {39, 28}}) {
        const auto now = static_cast<std::size_t>(index);
        const report::Canvas canvas = composer.compose(now, prepared.pictures(now));
        for (int k = 0; k < 12; ++k) {
            const std::vector<ComparedPicture> wanted =
                prepared.pictures(static_cast<std::size_t>(first + k));
            EXPECT_EQ(canvas.at(box.x + 5, box.y + k), pixel(wanted[1].rgb, 480, 5, 6)) << index << " " << k;
        }
    }
}

TEST_F(ComparePictureTest, MissingFramesAreBlanksThatSaySo) {
    const Prepared prepared({.sequences = {a, b}});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const std::vector<ComparedPicture> pictures = prepared.pictures(4);
    EXPECT_EQ(pictures[1].blank, "frame 5 is missing");
    const report::Canvas canvas = composer.compose(4, pictures);
    const Layout& layout = prepared.layout;
    for (const Box& box : {layout.sides[1].box, layout.wipe.box, layout.differences[0].box}) {
        EXPECT_EQ(canvas.at(box.x + 1, box.y + 1), kBlank);
        bool text = false;
        for (int x = 0; x < box.width; ++x) text |= canvas.at(box.x + x, box.y + box.height / 2) != kBlank;
        EXPECT_TRUE(text);
    }
    const Box& side = layout.sides[0].box;
    EXPECT_EQ(canvas.at(side.x, side.y), pixel(pictures[0].rgb, kWidth, 0, 0)) << "A is still there";
}

TEST_F(ComparePictureTest, LongLabelsStayInTheirColumns) {
    const std::string label =
        "a_very_long_folder_name/that_goes_on/and_on/until_the_very_end_of_the_clip_0042";
    const Prepared prepared({.sequences = {a, b, c}, .labels = {label, label + "B", label + "C"}});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, std::string(300, 'v'));
    const report::Canvas canvas = composer.compose(0, prepared.pictures(0));
    const auto clear = [&](int x, const Box& line) {
        for (int y = line.y; y < line.y + line.height; ++y) {
            EXPECT_EQ(canvas.at(x, y), kGround) << x << " " << y;
        }
    };
    for (const Panel& panel : prepared.layout.sides)
        clear(panel.caption.x + panel.caption.width + 2, panel.caption);
    clear(prepared.layout.wipe.footer.x + prepared.layout.wipe.footer.width + 2, prepared.layout.wipe.footer);
    clear(prepared.layout.wipe.footer.x + prepared.layout.wipe.footer.width / 2 + 2,
          prepared.layout.wipe.footer);
    clear(canvas.width() - 4, prepared.layout.header);
    clear(2, prepared.layout.header);
}

TEST_F(ComparePictureTest, TheSamePictureIsDrawnTwiceTheSame) {
    const Prepared prepared({.sequences = {a, b}});
    const Composer composer(prepared.comparison, prepared.found, prepared.layout, "view");
    const std::vector<ComparedPicture> pictures = prepared.pictures(3);
    const report::Canvas first = composer.compose(3, pictures), second = composer.compose(3, pictures);
    EXPECT_TRUE(std::ranges::equal(first.rgb(), second.rgb()));
}

TEST_F(ComparePictureTest, TheSheetHoldsThePicturesOfItsFrames) {
    const Prepared prepared({.sequences = {a, b}});
    Sheet sheet(prepared.comparison, prepared.found, 4, "view");
    ASSERT_EQ(sheet.picked(), (std::vector<std::size_t>{0, 2, 5, 7}));
    constexpr int kEnlarged = 2;  // 240 / 97
    for (std::size_t column = 0; column < 4; ++column) {
        const std::vector<ComparedPicture> pictures = prepared.pictures(sheet.picked()[column]);
        sheet.add(column, pictures);
        for (std::size_t row = 0; row < 2; ++row) {
            const Box box = sheet.cell(column, row);
            ASSERT_EQ(box.width, kWidth * kEnlarged);
            ASSERT_LE(box.x + box.width, sheet.canvas().width());
            ASSERT_LE(box.y + box.height, sheet.canvas().height());
            for (int y = 0; y < box.height; ++y) {
                for (int x = 0; x < box.width; ++x) {
                    ASSERT_EQ(sheet.canvas().at(box.x + x, box.y + y),
                              pixel(pictures[row].rgb, kWidth, x / kEnlarged, y / kEnlarged));
                }
            }
        }
        const Box box = sheet.cell(column, 2);
        const double value = std::abs(pictures[0].light.luminance[0] - pictures[1].light.luminance[0]) /
                             prepared.found.unit / prepared.found.difference_full;
        EXPECT_NEAR(sheet.canvas().at(box.x, box.y).red, report::heat(value).red, 1);
    }
}

TEST(CompareSheet, ReducesByTheMean) {
    // 5 x 3 to 2 x 1: the last column and row are cut off.
    std::vector<std::uint8_t> rgb(3 * 5 * 3, 255);
    const std::uint8_t values[2][4] = {{10, 20, 100, 0}, {30, 41, 0, 1}};
    for (std::size_t y = 0; y < 2; ++y) {
        for (std::size_t x = 0; x < 4; ++x) {
            for (std::size_t c = 0; c < 3; ++c)
                rgb[3 * (5 * y + x) + c] = static_cast<std::uint8_t>(values[y][x] + c);
        }
    }
    EXPECT_THAT(reduced(rgb, 5, 3, 2), testing::ElementsAre(25, 26, 27, 25, 26, 27));
    EXPECT_EQ(reduced(rgb, 5, 3, 1), rgb);
}

bool apart(const Box& a, const Box& b) {
    return a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y;
}

TEST(CompareLayout, PanelsLieInThePictureAndApart) {
    for (const auto& [width, height] :
         {std::pair{960, 540}, {96, 54}, {1920, 1080}, {1, 1}, {10, 900}, {900, 7}, {300, 300}}) {
        for (std::size_t sequences = 2; sequences <= 4; ++sequences) {
            for (std::size_t frames : {1u, 12u, 2000u}) {
                const Layout layout = plan_layout(width, height, sequences, frames, {});
                std::vector<Box> boxes{layout.header};
                const auto add = [&](const Panel& panel) {
                    for (const Box& box : {panel.box, panel.caption, panel.footer}) {
                        if (box.height > 0) boxes.push_back(box);
                    }
                };
                for (const auto* panels : {&layout.sides, &layout.differences, &layout.slices}) {
                    for (const Panel& panel : *panels) add(panel);
                }
                for (const Panel& panel : {layout.wipe, layout.mean_plot, layout.flicker_plot}) add(panel);
                for (std::size_t i = 0; i < boxes.size(); ++i) {
                    EXPECT_GE(boxes[i].x, 0);
                    EXPECT_LE(boxes[i].x + boxes[i].width, layout.width);
                    EXPECT_LE(boxes[i].y + boxes[i].height, layout.height);
                    for (std::size_t k = 0; k < i; ++k) {
                        EXPECT_TRUE(apart(boxes[i], boxes[k]))
                            << width << "x" << height << " " << i << " " << k;
                    }
                }
                EXPECT_EQ(layout.sides[0].box.width, width * layout.factor);
                EXPECT_LE(layout.factor, std::max(1, 480 / std::max(width, height)));
            }
        }
    }
}

TEST(CompareLayout, PartsCanBeLeftOut) {
    const Layout all = plan_layout(960, 540, 2, 10, {});
    EXPECT_EQ(all.width, 3 * 16 + 2 * 960);
    const Layout some = plan_layout(960, 540, 2, 10, {.side = false, .slice = false, .flicker = false});
    EXPECT_TRUE(some.sides.empty() && some.slices.empty());
    EXPECT_EQ(some.mean_plot.box.width, 0);
    EXPECT_EQ(some.wipe.box.height, 540);
    EXPECT_LT(some.height, 720);
    EXPECT_EQ(plan_layout(1920, 1080, 2, 10, {}).sides[0].caption.height, 3 * 28)
        << "text grows with the pictures";
    EXPECT_THROW(plan_layout(16000, 2000, 2, 10, {}), Error);
}

}  // namespace
}  // namespace dapple::judge
