#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "end_to_end/program.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing_tools::ChildProcess;
using testing_tools::file_text;
using testing_tools::pictures_in;
using testing_tools::run_program;
using testing_tools::ScratchFolder;

TEST(Render, ATimelineBecomesPicturesStatsManifestAndVideo) {
    const ScratchFolder scratch;
    const auto outcome =
        run_dapple(scratch, {"render", kSmall, "-o", scratch / "out", "--log-json", scratch / "log"});
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("6 frames rendered, 0 kept"));
    EXPECT_THAT(outcome.output, HasSubstr("flicker "));
    EXPECT_THAT(outcome.output, Not(HasSubstr("WARNING")));
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(12));

    const auto manifest = nlohmann::json::parse(file_text(scratch / "out/manifest.json"));
    EXPECT_THAT(manifest.at("frames"), SizeIs(6));
    EXPECT_EQ(manifest.at("made_with").at("display"), "sRGB");
    for (const char* part : {"timeline", "input files", "colour config", "program", "device type"}) {
        EXPECT_FALSE(manifest.at("made_of").at(part).get<std::string>().empty()) << part;
    }
    std::ifstream stats(scratch / "out/stats.jsonl");
    int frame = 0;
    for (std::string line; std::getline(stats, line);) {
        const auto json = nlohmann::json::parse(line);
        if (json.contains("clip")) {
            EXPECT_EQ(json.at("clip").at("measured_frames"), 4);
            break;
        }
        EXPECT_EQ(json.at("frame"), ++frame);
        EXPECT_GT(json.at("temporal").at("mean"), 0);
        EXPECT_EQ(json.at("temporal").contains("flicker"), frame > 1 && frame < 6);
        EXPECT_EQ(json.at("non_finite"), 0);
        EXPECT_GT(json.at("passes").size(), 5U);
        EXPECT_GT(json.at("counts").at("photons"), 1000);
    }
    EXPECT_EQ(frame, 6);

    const auto probe =
        run_program({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                     "stream=width,height,r_frame_rate,nb_read_frames,color_space,color_transfer", "-of",
                     "default=noprint_wrappers=1", scratch / "out/small.mp4"},
                    scratch / "probe.txt");
    for (const char* expected : {"width=64", "height=36", "r_frame_rate=24000/1001", "nb_read_frames=6",
                                 "color_space=bt709", "color_transfer=bt709"}) {
        EXPECT_THAT(probe.output, HasSubstr(expected));
    }

    const auto header = run_program({"oiiotool", "--info", "-v", scratch / "out/linear/small.0003.exr"},
                                    scratch / "probe.txt");
    for (const char* expected :
         {"24000/1001", "dapple:frame: \"3\"", "chromaticities: 0.713", "caustics.R", "E.G"}) {
        EXPECT_THAT(header.output, HasSubstr(expected));
    }
}

/// A frame is a pure function of timeline, number and program.
TEST(Render, AFrameHasTheSameBitsHoweverItIsMade) {
    const ScratchFolder scratch;
    const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"render", kSmall, "-o", scratch / name};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto outcome = run_dapple(scratch, arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        return pictures_in(scratch / name);
    };
    const auto whole = render("whole", {"--threads", "2"});
    ASSERT_THAT(whole, SizeIs(12));
    // Frames that do not differ would prove nothing.
    ASSERT_NE(whole.at("linear/small.0003.exr"), whole.at("linear/small.0004.exr"));

    EXPECT_TRUE(render("one thread", {"--threads", "1"}) == whole);
    EXPECT_TRUE(render("backwards", {"-f", "6-1"}) == whole);
    for (const auto& [name, content] : render("alone", {"-f", "4"}))
        EXPECT_TRUE(content == whole.at(name)) << name;
    for (const auto& [name, content] : render("range", {"-f", "2-5x3,3"}))
        EXPECT_TRUE(content == whole.at(name)) << name;

    ChildProcess child(dapple({"render", kSmall, "-o", scratch / "killed"}));
    for (int i = 0; i < 4000 && !std::filesystem::exists(scratch / "killed/graded/small.0002.exr"); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    child.signal(SIGKILL);
    child.wait();
    EXPECT_TRUE(render("killed", {}) == whole);
    EXPECT_TRUE(file_text(scratch / "killed/small.mp4") == file_text(scratch / "whole/small.mp4"));
}

TEST(Render, AnInterruptedReferenceGoesOnAndGivesTheSameBits) {
    const ScratchFolder scratch;
    const std::vector<std::string> job = {"--set", "caustics={method: reference, standard_error: 0.5 %}",
                                          "--set", "clip.resolution=[16, 9]",
                                          "--set", "clip.samples=1",
                                          "-f",    "1"};
    const auto arguments = [&](const std::string& folder) {
        std::vector<std::string> all = {"render", kSmall, "-o", scratch / folder};
        all.insert(all.end(), job.begin(), job.end());
        return all;
    };
    ASSERT_EQ(run_dapple(scratch, arguments("whole")).code, 0);
    const auto whole = pictures_in(scratch / "whole");
    ASSERT_THAT(whole, SizeIs(2));
    EXPECT_FALSE(std::filesystem::exists(scratch / "whole/checkpoint"));

    // The frame takes longer than the 0.1 s that it gets: it is broken off, not finished.
    ChildProcess child(dapple(arguments("broken off")));
    for (int i = 0; i < 4000 && !std::filesystem::exists(scratch / "broken off/checkpoint"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    child.signal(SIGTERM);
    EXPECT_EQ(child.wait(), 75);
    EXPECT_TRUE(std::filesystem::exists(scratch / "broken off/checkpoint/small.0001.partial"));
    EXPECT_TRUE(pictures_in(scratch / "broken off").empty());

    EXPECT_EQ(run_dapple(scratch, arguments("broken off")).code, 0);
    EXPECT_TRUE(pictures_in(scratch / "broken off") == whole);
    EXPECT_FALSE(std::filesystem::exists(scratch / "broken off/checkpoint"));
}

TEST(Render, StrictFailsAfterTheFramesAreComplete) {
    const ScratchFolder scratch;
    // Photon splatting serves only what the camera sees directly, and says so.
    const auto outcome =
        run_dapple(scratch, {"render", kSmall, "-o", scratch / "out", "-f", "1-2", "--strict"});
    EXPECT_EQ(outcome.code, 6);
    EXPECT_THAT(outcome.output, HasSubstr("--strict: frame 1 was done partly"));
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(4));
}

TEST(Render, AClipThatFlickersTooMuchFailsAfterItsFramesAreComplete) {
    const ScratchFolder scratch;
    const std::vector<std::string> job = {"render", kSmall, "-o", scratch / "out", "-f", "1-4"};
    const auto with_limit = [&](const std::string& limit) {
        std::vector<std::string> arguments = job;
        arguments.insert(arguments.end(), {"--max-flicker", limit});
        return run_dapple(scratch, arguments);
    };
    for (const char* limit : {"0", "-1", "nan", "inf", "much", "1e-3x", ""}) {
        const auto outcome = with_limit(limit);
        EXPECT_EQ(outcome.code, 2) << limit;
        EXPECT_THAT(outcome.output, HasSubstr("is no number above 0")) << limit;
    }
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));

    const auto failed = with_limit("1e-9");
    EXPECT_EQ(failed.code, 6) << failed.output;
    EXPECT_THAT(failed.output, HasSubstr("--max-flicker: more than 1e-09 in frames 2 ("));
    EXPECT_THAT(failed.output, HasSubstr(", 3 ("));
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(8));
    EXPECT_EQ(with_limit("1e3").code, 0);
}

TEST(Render, SaysThatFramesLieOutsideTheClip) {
    const ScratchFolder scratch;
    const auto outside = run_dapple(scratch, {"render", kSmall, "-f", "6,7", "-o", scratch / "out"});
    EXPECT_EQ(outside.code, 0);
    EXPECT_THAT(outside.output, HasSubstr("1 frames lie outside the clip"));
    const auto inside = run_dapple(scratch, {"render", kSmall, "-f", "6", "-o", scratch / "out"});
    EXPECT_THAT(inside.output, Not(HasSubstr("outside the clip")));
}

TEST(Render, WithoutAnEncoderThereIsAWarning) {
    const ScratchFolder scratch;
    const auto outcome = run_program(
        {"/usr/bin/env", "PATH=/nonexistent", DAPPLE_PROGRAM, "render", kSmall, "-o", scratch / "out"},
        scratch / "output.txt");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.output, HasSubstr("WARNING no preview: ffmpeg cannot be started"));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out/small.mp4"));
    EXPECT_EQ(run_dapple(scratch, {"render", kSmall, "-o", scratch / "out"}).code, 0);
    EXPECT_TRUE(std::filesystem::exists(scratch / "out/small.mp4"));
}

TEST(Render, PlanAndDryRunWriteNothing) {
    const ScratchFolder scratch;
    const auto plan = run_dapple(scratch, {"render", kSmall, "-o", scratch / "out", "--plan"});
    EXPECT_EQ(plan.code, 0);
    EXPECT_THAT(plan.output, HasSubstr("caustics: photon_splatting"));
    EXPECT_THAT(plan.output, HasSubstr("sun > water:T"));

    const auto dry =
        run_dapple(scratch, {"render", kSmall, "-o", scratch / "out", "--dry-run", "-f", "2-6x2"});
    EXPECT_EQ(dry.code, 0);
    EXPECT_THAT(dry.output, HasSubstr("/out/linear/small.0004.exr"));
    EXPECT_THAT(dry.output, HasSubstr("3 frames (2-6x2) of 64x36"));
    EXPECT_THAT(dry.output, HasSubstr("memory: about"));
    EXPECT_THAT(dry.output, HasSubstr("disk: at most"));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
}

TEST(Render, FourCascadesOf2048FitIntoFourGibibytesAtFullHd) {
    const ScratchFolder scratch;
    for (const char* clip : {"cascades", "town"})  // the latter above the water and below
        for (const char* method : {"photon_splatting", "caustic_mesh"}) {
            const auto dry = run_dapple(
                scratch, {"render", std::string(DAPPLE_SOURCE_DIR) + "/sequences/" + clip + ".yaml", "-o",
                          scratch / "out", "--dry-run", "-f", "1,45", "--max-memory", "4G", "--set",
                          "clip.resolution=[1920, 1080]", "--set", std::string("caustics.method=") + method,
                          "--set", "caustics.map_resolution=2048"});
            EXPECT_EQ(dry.code, 0) << clip << " by " << method << ": " << dry.output;
        }
}

TEST(Validate, DescribesASoundTimeline) {
    const ScratchFolder scratch;
    const auto outcome = run_dapple(scratch, {"validate", kSmall});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.output, HasSubstr("is valid: clip small, frames 1-6 at 24000/1001 fps, 64x36"));
}

TEST(Info, NamesDevicesVersionsAndKeys) {
    const ScratchFolder scratch;
    const auto info = run_dapple(scratch, {"info"});
    EXPECT_EQ(info.code, 0);
    for (const char* expected : {"dapple ", "embree ", "device ", "Vulkan 1.3", "colour ", "avx2"}) {
        EXPECT_THAT(info.output, HasSubstr(expected));
    }
    const auto keys = run_dapple(scratch, {"info", "--keys"});
    EXPECT_EQ(keys.code, 0);
    EXPECT_THAT(keys.output, HasSubstr("resolution"));
}

}  // namespace
}  // namespace dapple::end_to_end
