#include "metrics/flicker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/parallel.h"
#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kWidth = 40, kHeight = 30;

Picture grey(const std::function<float(int x, int y)>& value) {
    return picture_by(kWidth, kHeight, [&](int x, int y) { return glm::vec3(value(x, y)); });
}

/// A picture whose pixels differ, all of them multiples of 1/64, so that sums of them are exact.
float pattern(int x, int y) {
    return 1 + static_cast<float>((5 * x + 3 * y) % 64) / 64;
}

using Clip = std::vector<Picture>;

std::map<std::int64_t, FrameFlicker> figures_of(const Clip& clip) {
    std::map<std::int64_t, FrameFlicker> figures;
    const auto last = static_cast<std::int64_t>(clip.size()) - 1;
    for (std::int64_t t = 0; t <= last; ++t) {
        const auto i = static_cast<std::size_t>(t);
        figures[t] =
            t == 0 || t == last ? lone_frame(clip[i]) : frame_flicker(clip[i - 1], clip[i], clip[i + 1]);
    }
    return figures;
}

/// The pattern in every frame, plus `more(t)`.
Clip clip_of(int frames, const std::function<float(int t)>& more) {
    Clip clip;
    for (int t = 0; t < frames; ++t) {
        clip.push_back(grey([&](int x, int y) { return pattern(x, y) + more(t); }));
    }
    return clip;
}

TEST(Flicker, OfAStillClipIsNone) {
    const auto figures = figures_of(clip_of(5, [](int) { return 0.0f; }));
    double sum = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) sum += static_cast<double>(pattern(x, y));
    }
    EXPECT_EQ(figures.at(2).mean, sum / (kWidth * kHeight));
    EXPECT_EQ(figures.at(2).change_before, 0);
    EXPECT_EQ(figures.at(2).change_after, 0);
    EXPECT_EQ(figures.at(2).high_pass_energy, 0);
    EXPECT_THAT(figures.at(2).histogram, ElementsAre(kWidth * kHeight));
    const ClipFlicker clip = clip_flicker(figures);
    EXPECT_EQ(clip.mean, sum / (kWidth * kHeight));
    EXPECT_EQ(clip.flicker, 0);
    EXPECT_EQ(clip.median_term, 0);
    ASSERT_EQ(clip.frames.size(), 3u);
    for (const auto& [number, frame] : clip.frames) {
        EXPECT_EQ(frame.flicker, 0) << number;
        EXPECT_EQ(frame.jump_share, 0) << number;
    }
    EXPECT_EQ(clip.worst_frame, 1);
}

TEST(Flicker, OfAFlashIsItsSquareThereAndAQuarterBeside) {
    const auto figures = figures_of(clip_of(9, [](int t) { return t == 4 ? 0.5f : 0.0f; }));
    for (const auto& [t, frame] : figures) {
        EXPECT_EQ(frame.high_pass_energy, t == 4 ? 0.25 : t == 3 || t == 5 ? 0.0625 : 0) << t;
        EXPECT_EQ(frame.change_before, t == 4 || t == 5 ? 0.5 : 0) << t;
        EXPECT_EQ(frame.change_after, t == 4 || t == 3 ? 0.5 : 0) << t;
    }
    const ClipFlicker clip = clip_flicker(figures);
    // The mean is over all nine frames, the two at the ends too; in doubles, of nine terms.
    const double mean = figures.at(1).mean + 0.5 / 9;
    EXPECT_NEAR(clip.mean, mean, 1e-14);
    EXPECT_NEAR(clip.frames.at(4).flicker, 0.25 / (mean * mean), 1e-14);
    EXPECT_NEAR(clip.frames.at(5).flicker, 0.0625 / (mean * mean), 1e-14);
    EXPECT_NEAR(clip.flicker, (0.25 + 2 * 0.0625) / 7 / (mean * mean), 1e-14);
    EXPECT_EQ(clip.worst_frame, 4);
    EXPECT_EQ(clip.frames.size(), 7u);
}

TEST(Flicker, OfALinearDriftIsNone) {
    const auto figures = figures_of(clip_of(8, [](int t) { return static_cast<float>(t) / 32; }));
    for (std::int64_t t = 1; t < 7; ++t) {
        EXPECT_EQ(figures.at(t).high_pass_energy, 0);
        EXPECT_EQ(figures.at(t).change_before, 1.0 / 32);
    }
}

TEST(Flicker, AgainstAReferenceIsThatOfTheError) {
    const auto moving = [](int t) { return static_cast<float>((5 * t * t) % 8) / 8; };
    const Clip reference = clip_of(5, moving);
    const Clip picture = clip_of(5, [&](int t) { return moving(t) + (t % 2 == 0 ? 0.25f : -0.25f); });
    const FrameFlicker figures =
        frame_flicker(picture[1], picture[2], picture[3], reference[1], reference[2], reference[3]);
    EXPECT_EQ(figures.high_pass_energy, 0.25);  // (2 a)^2
    EXPECT_EQ(figures.change_after, 0.5);
    EXPECT_EQ(figures.mean, lone_frame(picture[2]).mean);
    EXPECT_NE(frame_flicker(picture[1], picture[2], picture[3]).high_pass_energy, 0.25);
    EXPECT_EQ(
        frame_flicker(reference[1], reference[2], reference[3], reference[1], reference[2], reference[3])
            .high_pass_energy,
        0);
}

TEST(Flicker, CountsPixelsByTheirTerm) {
    // H = 1/2 in one pixel, 1/4 in two, 2^-60 in one, the others 0: H^2 at the lower ends of bins.
    const Picture still = grey([](int, int) { return 0.0f; });
    Picture frame = still;
    frame.luminance[0] = 0.5f;
    frame.luminance[1] = frame.luminance[2] = 0.25f;
    frame.luminance[3] = 0x1p-60f;
    frame.luminance[4] = 1.1f;  // H^2 = 1.21, in the second quarter of its octave
    frame.luminance[5] = 1e30f;
    const FrameFlicker figures = frame_flicker(still, frame, still);
    std::map<std::size_t, std::uint32_t> bins;
    for (std::size_t bin = 0; bin < figures.histogram.size(); ++bin) {
        if (figures.histogram[bin] > 0) bins[bin] = figures.histogram[bin];
    }
    const std::map<std::size_t, std::uint32_t> expected = {
        {0, kWidth * kHeight - 5}, {4 * 98 + 1, 1}, {4 * 96 + 1, 2}, {4 * 100 + 2, 1}, {801, 1}};
    EXPECT_EQ(bins, expected);
}

TEST(Flicker, JumpsAreFarAboveTheClipsMedian) {
    // Every pixel trembles, so that H = 1/64, and 60 pixels of frame 4 flash by 1.5 on top.
    const auto tremble = [](int t) { return t % 2 == 0 ? 1.0f / 64 : 0.0f; };
    Clip clip = clip_of(9, tremble);
    for (std::size_t i = 100; i < 160; ++i) clip[4].luminance[i] += 1.5f;
    const ClipFlicker figures = clip_flicker(figures_of(clip));
    // The upper end of the bin that begins at 2^-12 (H = 1/64); a jump is 32 times as high, H = 0.55: the
    // neighbours' 1.5 / 2 exceed that too.
    EXPECT_NEAR(figures.median_term, 0x1p-12 * std::exp2(0.25), 1e-18);
    EXPECT_NEAR(figures.jump_term, 1024 * figures.median_term, 1e-15);
    for (const auto& [t, frame] : figures.frames) {
        EXPECT_EQ(frame.jump_share, t >= 3 && t <= 5 ? 60.0 / (kWidth * kHeight) : 0) << t;
    }
    EXPECT_EQ(figures.worst_frame, 4);

    // One pixel with H just below and just above the root of jump_term, 0.545.
    for (const auto& [high_pass, jumps] : {std::pair{0.54f, false}, {0.55f, true}}) {
        Clip edge = clip_of(9, tremble);
        edge[4].luminance[7] += high_pass - 1.0f / 64;
        EXPECT_EQ(clip_flicker(figures_of(edge)).frames.at(4).jump_share > 0, jumps) << high_pass;
    }

    // Without the tremble a jump must still exceed 32 times 1e-4 of the mean.
    for (const auto& [step, jumps] : {std::pair{0x1p-10f, false}, {0x1p-4f, true}}) {
        Clip quiet = clip_of(5, [](int) { return 0.0f; });
        quiet[2].luminance[7] += step;
        EXPECT_EQ(clip_flicker(figures_of(quiet)).frames.at(2).jump_share > 0, jumps) << step;
    }
}

TEST(Flicker, LeavesOutExcludedPixels) {
    Clip clip = clip_of(3, [](int t) { return t == 1 ? 0.5f : 0.0f; });
    const FrameFlicker whole = frame_flicker(clip[0], clip[1], clip[2]);
    // Each pixel is excluded from one frame; the others hold what would be seen.
    const std::uint32_t pixels[] = {3, 700, kWidth * kHeight - 1};
    for (std::size_t t = 0; t < 3; ++t) {
        for (Picture& picture : clip) picture.luminance[pixels[t]] = 1000;
        exclude(clip[t], pixels[t]);
    }
    const FrameFlicker figures = frame_flicker(clip[0], clip[1], clip[2]);
    EXPECT_EQ(figures.high_pass_energy, whole.high_pass_energy);
    EXPECT_EQ(figures.change_before, whole.change_before);
    EXPECT_EQ(figures.excluded, 3u);
    std::uint32_t counted = 0;
    for (const std::uint32_t pixels_of_bin : figures.histogram) counted += pixels_of_bin;
    EXPECT_EQ(counted, kWidth * kHeight - 3u);
    // The mean is that of the frame alone, which excludes one of them.
    double sum = 0;
    for (const float value : clip[1].luminance) sum += static_cast<double>(value);
    EXPECT_DOUBLE_EQ(figures.mean, sum / (kWidth * kHeight - 1));
    EXPECT_EQ(figures.mean, lone_frame(clip[1]).mean);

    Picture nothing = grey([](int, int) { return 0.0f; });
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) exclude(nothing, i);
    const FrameFlicker none = frame_flicker(clip[0], nothing, clip[2]);
    EXPECT_EQ(none.high_pass_energy, 0);
    EXPECT_EQ(clip_flicker({{1, none}}).frames.at(1).jump_share, 0);
}

TEST(Flicker, OfClipsWithoutFiguresIsNone) {
    EXPECT_THAT(clip_flicker({}).frames, IsEmpty());
    const Picture one = grey(pattern);
    const ClipFlicker lone = clip_flicker({{7, lone_frame(one)}});
    EXPECT_THAT(lone.frames, IsEmpty());
    EXPECT_EQ(lone.mean, lone_frame(one).mean);
    EXPECT_FALSE(lone.worst_frame.has_value());
    // What flickers about a mean of 0 must not pass for still.
    const Picture black = grey([](int, int) { return 0.0f; });
    const Picture board = grey([](int x, int y) { return (x + y) % 2 == 0 ? 1.0f : -1.0f; });
    EXPECT_EQ(clip_flicker({{1, frame_flicker(black, board, black)}}).flicker, HUGE_VAL);
    EXPECT_EQ(clip_flicker({{1, frame_flicker(black, black, black)}}).flicker, 0);
}

TEST(Flicker, HasTheSameBitsOnAnyNumberOfThreads) {
    // More pixels than a tile, of values whose sums round.
    const auto noise = [](std::uint64_t frame) {
        return picture_by(300, 200, [frame](int x, int y) {
            return glm::vec3(
                static_cast<float>(hash_uniform(3, frame, static_cast<std::uint64_t>(y * 300 + x), 0)));
        });
    };
    const Picture frames[] = {noise(0), noise(1), noise(2)};
    const FrameFlicker whole = frame_flicker(frames[0], frames[1], frames[2]);
    set_thread_count(1);
    EXPECT_EQ(frame_flicker(frames[0], frames[1], frames[2]), whole);
    set_thread_count(0);
    // H of three uniform values has variance (1 + 1/4 + 1/4) / 12; 3 % is many of its errors, 60000^-1/2.
    EXPECT_NEAR(whole.high_pass_energy, 0.125, 0.004);
}

}  // namespace
}  // namespace dapple::metrics
