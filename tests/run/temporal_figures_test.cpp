#include "run/temporal_figures.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "image/exr.h"
#include "run/frame_loop_fixture.h"
#include "run/told_figures.h"

namespace dapple::run {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing_tools::file_text;
using testing_tools::pictures_in;
using testing_tools::told;
using testing_tools::Told;
using Json = nlohmann::ordered_json;

std::vector<std::int64_t> measured_frames(const Told& told) {
    std::vector<std::int64_t> frames;
    for (const auto& [frame, text] : told.frames) {
        if (Json::parse(text).contains("high_pass_energy")) frames.push_back(frame);
    }
    return frames;
}

metrics::Picture picture_at(const std::string& folder, std::int64_t frame) {
    const std::string path = folder + "/linear/fake.000" + std::to_string(frame) + ".exr";
    return metrics::picture_of(image::read_exr(path), "", path);
}

class TemporalFiguresTest : public FrameLoopTest {
protected:
    // Luminance must be that of the file's primaries, not of a default's.
    TemporalFiguresTest() { options.linear_exr.chromaticities = image::kAcesCgChromaticities; }
};

TEST_F(TemporalFiguresTest, AreThoseOfTheFilesLuminance) {
    event_log = scratch / "events.jsonl";
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    const Told figures = told(scratch / "out");
    EXPECT_THAT(measured_frames(figures), ElementsAre(2, 3, 4, 5));

    std::map<std::int64_t, metrics::FrameFlicker> expected;
    for (std::int64_t t = 1; t <= 6; ++t) {
        const metrics::Picture frame = picture_at(scratch / "out", t);
        expected[t] = t == 1 || t == 6 ? metrics::lone_frame(frame)
                                       : metrics::frame_flicker(picture_at(scratch / "out", t - 1), frame,
                                                                picture_at(scratch / "out", t + 1));
    }
    const metrics::ClipFlicker clip = metrics::clip_flicker(expected);
    for (const auto& [t, frame] : expected) {
        const Json json = Json::parse(figures.frames.at(t));
        EXPECT_EQ(json.at("mean"), frame.mean);
        if (t == 1 || t == 6) {
            EXPECT_THAT(json.at("inputs"), SizeIs(1));
            continue;
        }
        EXPECT_THAT(json.at("inputs"), SizeIs(3));
        EXPECT_EQ(json.at("change_before"), frame.change_before);
        EXPECT_EQ(json.at("change_after"), frame.change_after);
        EXPECT_EQ(json.at("high_pass_energy"), frame.high_pass_energy);
        EXPECT_EQ(json.at("flicker"), clip.frames.at(t).flicker);
        EXPECT_EQ(json.at("jump_share"), clip.frames.at(t).jump_share);
    }
    const Json summary = Json::parse(figures.clip);
    EXPECT_EQ(summary.at("measured_frames"), 4);
    EXPECT_EQ(summary.at("mean"), clip.mean);
    EXPECT_EQ(summary.at("flicker"), clip.flicker);
    EXPECT_EQ(summary.at("median_term"), clip.median_term);
    EXPECT_EQ(summary.at("worst_frame"), *clip.worst_frame);

    const std::string frame = "in frame " + std::to_string(*clip.worst_frame);
    EXPECT_THAT(out, AllOf(HasSubstr("flicker "), HasSubstr(frame)));
    EXPECT_THAT(file_text(event_log), HasSubstr("\"event\":\"clip_measured\""));
}

TEST_F(TemporalFiguresTest, AFlashExceedsTheLimitAndIsNamed) {
    source.flash = {{4, 3.0f}};
    options.max_flicker = 0.7;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(12));
    const Told figures = told(scratch / "out");
    const auto flicker = [&](std::int64_t frame) {
        return Json::parse(figures.frames.at(frame)).at("flicker").get<double>();
    };
    // 3^2 over the clip's mean squared, (1/2 + 3/6)^2, beside it a quarter of that, and noise.
    EXPECT_NEAR(flicker(4), 9, 1);
    EXPECT_NEAR(flicker(5), 9.0 / 4, 0.5);
    EXPECT_LT(flicker(2), 0.7);
    char expected[200];
    std::snprintf(expected, sizeof expected,
                  "--max-flicker: more than 0.7 in frames 3 (%.4g), 4 (%.4g), 5 (%.4g); 6 frames rendered",
                  flicker(3), flicker(4), flicker(5));
    EXPECT_THAT(out, HasSubstr(expected));

    // The same of kept frames, also of those that the call did not ask for.
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(source.rendered, IsEmpty());
    EXPECT_EQ(render(scratch / "out", "1"), ExitCode::check_failed);
    options.max_flicker = 4;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(out, AllOf(HasSubstr("in frame 4 ("), Not(HasSubstr("frames 3"))));
    options.max_flicker = 20;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_EQ(told(scratch / "out"), figures);

    options.max_flicker = 4;
    options.strict = true;
    source.not_finite = {2};
    EXPECT_EQ(render(scratch / "out", "1-6", Existing::overwrite), ExitCode::check_failed);
    EXPECT_THAT(out, AllOf(HasSubstr("--strict: frame 2 had 1 values"), HasSubstr("--max-flicker: more")));
}

TEST_F(TemporalFiguresTest, ALimitWithoutNeighboursIsNotPassedInSilence) {
    options.max_flicker = 1e-9;
    EXPECT_EQ(render(scratch / "out", "1-6x2"), ExitCode::done);
    EXPECT_THAT(warnings, HasSubstr("--max-flicker: no frame has both neighbours"));
    EXPECT_THAT(out, Not(HasSubstr("flicker")));
    EXPECT_EQ(told(scratch / "out").clip, "");
    EXPECT_EQ(render(scratch / "out", "2"), ExitCode::check_failed);
    EXPECT_THAT(warnings, IsEmpty());
}

TEST_F(TemporalFiguresTest, AreTheSameHoweverTheClipIsMade) {
    source.flash = {{3, 0.5f}};
    ASSERT_EQ(render(scratch / "whole", "1-6"), ExitCode::done);
    const Told whole = told(scratch / "whole");
    ASSERT_THAT(whole.frames, SizeIs(6));
    ASSERT_FALSE(whole.clip.empty());

    const std::vector<std::string> orders[] = {{"6-1"},        {"1-6x2,2-6x2"},          {"4,1,6,2,5,3"},
                                               {"1-3", "1-6"}, {"5-6", "1-2", "3", "4"}, {"2", "1-6"}};
    int number = 0;
    for (const std::vector<std::string>& order : orders) {
        const std::string folder = scratch / std::to_string(number++);
        for (const std::string& frames : order) ASSERT_EQ(render(folder, frames), ExitCode::done);
        EXPECT_EQ(told(folder), whole) << order.front();
    }
    ASSERT_EQ(render(scratch / "whole", "1-6", Existing::overwrite), ExitCode::done);
    EXPECT_EQ(told(scratch / "whole"), whole);

    source.slow = {4};
    source.steps_before_stop = 4;
    ASSERT_EQ(render(scratch / "interrupted", "1-6"), ExitCode::interrupted);
    // The frames have what is known of them; shares in the clip and its line come with its end.
    const Told part = told(scratch / "interrupted");
    EXPECT_THAT(measured_frames(part), ElementsAre(2));
    EXPECT_THAT(part.frames.at(2), Not(HasSubstr("jump_share")));
    EXPECT_EQ(part.clip, "");
    source.steps_before_stop = -1;
    ASSERT_EQ(render(scratch / "interrupted", "1-6"), ExitCode::done);
    EXPECT_EQ(told(scratch / "interrupted"), whole);
}

/// As after a kill between a frame's entry and its figures, or where the file was edited.
TEST_F(TemporalFiguresTest, WhatWasLostIsMeasuredAgain) {
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    const std::string stats = scratch / "out/stats.jsonl";
    const Told whole = told(scratch / "out");
    const std::string text = file_text(stats);

    std::filesystem::remove(stats);
    ASSERT_EQ(render(scratch / "out", "6"), ExitCode::done);
    EXPECT_THAT(source.rendered, IsEmpty());
    EXPECT_EQ(told(scratch / "out"), whole);

    for (const auto& [from, to] :
         std::map<std::string, std::string>{{"\"high_pass_energy\"", "\"other\""},
                                            {"\"first_bin\":", "\"first_bin\":99999999"},
                                            {"\"inputs\":[\"", "\"inputs\":[\"0"},
                                            {"\"temporal\":{", "\"temporal\":[],\"before\":{"}}) {
        std::string edited = text;
        for (std::size_t at = edited.find(from); at != std::string::npos;
             at = edited.find(from, at + to.size()))
            edited.replace(at, from.size(), to);
        ASSERT_NE(edited, text);
        std::ofstream(stats) << edited;
        ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
        EXPECT_EQ(told(scratch / "out"), whole) << to;
    }
}

TEST_F(TemporalFiguresTest, FramesWithoutBothNeighboursHaveTheirMeanOnly) {
    ASSERT_EQ(render(scratch / "out", "1-2,4-6"), ExitCode::done);
    const Told gap = told(scratch / "out");
    EXPECT_THAT(measured_frames(gap), ElementsAre(5));
    EXPECT_THAT(gap.frames, SizeIs(5));
    ASSERT_EQ(render(scratch / "out", "3"), ExitCode::done);
    const Told filled = told(scratch / "out");
    EXPECT_THAT(measured_frames(filled), ElementsAre(2, 3, 4, 5));
    ASSERT_EQ(render(scratch / "whole", "1-6"), ExitCode::done);
    EXPECT_EQ(filled, told(scratch / "whole"));
}

TEST_F(TemporalFiguresTest, AFrameThatIsRenderedDifferentlyRefreshesItsNeighbours) {
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    const Told before = told(scratch / "out");
    source.flash = {{3, 2.0f}};
    ASSERT_EQ(render(scratch / "out", "3", Existing::overwrite), ExitCode::done);
    ASSERT_EQ(render(scratch / "flash", "1-6"), ExitCode::done);
    const Told after = told(scratch / "out");
    EXPECT_EQ(after, told(scratch / "flash"));
    for (const std::int64_t frame : {2, 3, 4}) EXPECT_NE(after.frames.at(frame), before.frames.at(frame));
    const auto inputs = [](const Told& told, std::int64_t frame) {
        return Json::parse(told.frames.at(frame)).at("inputs");
    };
    EXPECT_EQ(inputs(after, 5), inputs(before, 5));

    // Where there is no time to measure anew, what no longer holds goes: 4 waits for 5.
    source.flash = {{3, 1.0f}};
    source.slow = {5};
    source.steps_before_stop = 4;
    ASSERT_EQ(render(scratch / "out", "3,5", Existing::overwrite), ExitCode::interrupted);
    EXPECT_FALSE(told(scratch / "out").frames.contains(4));
    EXPECT_TRUE(told(scratch / "out").frames.contains(3));
}

TEST_F(TemporalFiguresTest, OfAPictureThatIsGoneAreMissing) {
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    std::filesystem::remove(scratch / "out/stats.jsonl");
    std::filesystem::remove(scratch / "out/linear/fake.0003.exr");
    ASSERT_EQ(render(scratch / "out", "5"), ExitCode::done);
    EXPECT_THAT(warnings, AllOf(HasSubstr("1 frames and their neighbours have no temporal figures"),
                                HasSubstr("linear/fake.0003.exr")));
    const Told figures = told(scratch / "out");
    EXPECT_THAT(measured_frames(figures), ElementsAre(5));
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_THAT(measured_frames(told(scratch / "out")), ElementsAre(2, 3, 4, 5));
}

/// Without a loop, and at first without any files: the pictures at hand must do.
class TemporalFiguresAlone : public testing::Test {
protected:
    TemporalFiguresAlone() { paths.make_folders(); }

    void finish(std::int64_t frame, TemporalFigures& figures) {
        finished[frame].linear.content_hash = "hash of " + std::to_string(frame);
        FrameStats stats;
        const SourceFrame rendered = source.render(frame, stats, {});
        figures.frame_done(frame, &rendered.linear);
    }

    testing_tools::ScratchFolder scratch;
    OutputPaths paths{scratch / "out", "fake"};
    std::map<std::int64_t, FrameEntry> finished;
    FakeSource source;
};

TEST_F(TemporalFiguresAlone, InOrderNoPictureIsReadAgain) {
    for (const std::string order : {"1-6", "6-1", "2,1,3-6"}) {
        finished.clear();
        const FrameSet frames = FrameSet::parse(order);
        TemporalFigures figures(paths, finished, frames);
        for (const std::int64_t frame : frames.frames()) finish(frame, figures);
        ASSERT_TRUE(figures.complete([] { return false; }));
        EXPECT_THAT(figures.unreadable(), IsEmpty()) << order;
        EXPECT_THAT(figures.clip().frames, SizeIs(4)) << order;
        std::filesystem::remove(paths.stats());
    }
    // Three pictures are all that is kept: the first is gone when the second comes.
    finished.clear();
    const FrameSet frames = FrameSet::parse("1,3,4,5,6,2");
    TemporalFigures figures(paths, finished, frames);
    for (const std::int64_t frame : frames.frames()) finish(frame, figures);
    EXPECT_THAT(figures.unreadable(), testing::Contains(1));
}

TEST_F(TemporalFiguresAlone, StopsWhereItIsAskedTo) {
    TemporalFigures figures(paths, finished, FrameSet::range(1, 6));
    for (const std::int64_t frame : {1, 2, 3}) finish(frame, figures);
    EXPECT_FALSE(figures.complete([] { return true; }));
}

TEST_F(TemporalFiguresAlone, WhatIsNotFiniteCountsAsTheFileHasIt) {
    for (const std::int64_t frame : {1, 2, 3}) {
        FrameStats stats;
        SourceFrame rendered = source.render(frame, stats, {});
        if (frame == 2) rendered.linear.find("G")->values[7] = std::numeric_limits<float>::quiet_NaN();
        const image::WrittenExr file = image::write_exr_verified(paths.linear(frame), rendered.linear);
        finished[frame].linear = {file.bytes, file.content_hash};
    }
    TemporalFigures read(paths, finished, FrameSet{});
    ASSERT_TRUE(read.complete([] { return false; }));
    std::filesystem::remove(paths.stats());

    TemporalFigures figures(paths, finished, FrameSet::range(1, 3));
    for (const std::int64_t frame : {1, 2, 3}) {
        FrameStats stats;
        SourceFrame rendered = source.render(frame, stats, {});
        if (frame == 2) rendered.linear.find("G")->values[7] = std::numeric_limits<float>::quiet_NaN();
        figures.frame_done(frame, &rendered.linear);
    }
    ASSERT_EQ(read.clip().frames.size(), 1u);
    EXPECT_EQ(figures.clip().frames.at(2).flicker, read.clip().frames.at(2).flicker);
}

}  // namespace
}  // namespace dapple::run
