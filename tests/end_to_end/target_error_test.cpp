// caustics.target_error through the whole program: settings are chosen once, and every frame has them.
// DAPPLE_LONG: also those that render for minutes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "end_to_end/program.h"
#include "run/manifest.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::Outcome;
using testing_tools::ScratchFolder;

constexpr const char* kTarget = "caustics={method: photon_splatting, target_error: 30 %}";

Outcome render(const ScratchFolder& scratch, const std::string& out, std::vector<std::string> more,
               const char* caustics = kTarget) {
    std::vector<std::string> arguments{"render", kSmall, "--set", caustics, "-o", scratch / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_dapple(scratch, arguments);
}

nlohmann::json settled_in(const std::string& folder) {
    return nlohmann::json::parse(file_text(folder + "/manifest.json")).at("settled");
}

TEST(TargetError, AFrameAloneAndAClipTakenUpAgainHaveTheSameBytes) {
    const ScratchFolder scratch;
    const Outcome clip = render(scratch, "clip", {"-f", "3-5"});
    ASSERT_EQ(clip.code, 0) << clip.output;
    EXPECT_THAT(clip.output, HasSubstr("target error: 30 %: map_resolution "));
    EXPECT_THAT(clip.output, HasSubstr("in frames 1, 3, 6"));
    const nlohmann::json settled = settled_in(scratch / "clip");
    EXPECT_EQ(settled.at("target_error"), 0.3);
    EXPECT_EQ(settled.at("pilots").size(), 3U);
    EXPECT_LE(settled.at("pilots").at(1).at("error"), 0.3);

    const Outcome alone = render(scratch, "alone", {"-f", "4", "--threads", "1"});
    ASSERT_EQ(alone.code, 0) << alone.output;
    EXPECT_EQ(settled_in(scratch / "alone"), settled);
    const std::string picture = file_text(scratch / "clip/linear/small.0004.exr");
    EXPECT_TRUE(file_text(scratch / "alone/linear/small.0004.exr") == picture);

    std::ifstream stats(scratch / "alone/stats.jsonl");
    std::string line;
    std::getline(stats, line);
    const auto counts = nlohmann::json::parse(line).at("counts");
    EXPECT_EQ(counts.at("settled map_resolution"), settled.at("map_resolution"));
    EXPECT_EQ(counts.at("estimated error, frame 6"), settled.at("pilots").at(2).at("error"));

    // What the manifest says is taken up, not found anew: other settings would be other pictures.
    nlohmann::json manifest = nlohmann::json::parse(file_text(scratch / "clip/manifest.json"));
    manifest.at("settled").at("map_resolution") = 200;
    std::ofstream(scratch / "clip/manifest.json") << manifest;
    std::filesystem::remove(scratch / "clip/linear/small.0004.exr");
    EXPECT_EQ(render(scratch, "clip", {"-f", "3-5"}).code, 0);
    EXPECT_FALSE(file_text(scratch / "clip/linear/small.0004.exr") == picture);
    // Another target is another job, whose settings are its own.
    const Outcome other =
        render(scratch, "clip", {"-f", "3-5"}, "caustics={method: photon_splatting, target_error: 20 %}");
    EXPECT_EQ(other.code, 2) << other.output;
    EXPECT_THAT(other.output, HasSubstr("other: the timeline"));
}

#if DAPPLE_LONG
TEST(TargetError, AClipThatIsKilledAndTakenUpHasTheSameSettingsAndBytes) {
    const ScratchFolder scratch;
    ASSERT_EQ(render(scratch, "whole", {}).code, 0);
    const nlohmann::json settled = settled_in(scratch / "whole");
    const auto whole = testing_tools::pictures_in(scratch / "whole");
    ASSERT_THAT(whole, testing::SizeIs(12));
    // Among the pilots, which take most of the time; when a manifest holds what is settled; after a frame.
    int ended = 0;
    for (const char* awaited : {"", "/manifest.json", "/graded/small.0001.exr"}) {
        for (const int signal : {SIGKILL, SIGTERM}) {
            SCOPED_TRACE(std::string(awaited) + ", signal " + std::to_string(signal));
            const std::string name = "ended" + std::to_string(ended), folder = scratch / name;
            testing_tools::ChildProcess child(dapple({"render", kSmall, "--set", kTarget, "-o", folder}));
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            for (int i = 0; i < 60'000 && *awaited != 0 && !std::filesystem::exists(folder + awaited); ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            child.signal(signal);
            EXPECT_NE(child.wait(), 0) << "the signal came too late to test anything";
            ++ended;
            const auto manifest = run::read_manifest(folder + "/manifest.json");
            EXPECT_EQ(manifest && manifest->settled, *awaited != 0);
            const Outcome resumed = render(scratch, name, {});
            ASSERT_EQ(resumed.code, 0) << resumed.output;
            EXPECT_EQ(settled_in(folder), settled);
            EXPECT_TRUE(testing_tools::pictures_in(folder) == whole);
        }
    }
}

#endif

TEST(TargetError, PlansAndDryRunsTellWhatIsChosen) {
    const ScratchFolder scratch;
    const Outcome plan = render(scratch, "out", {"--plan"});
    EXPECT_EQ(plan.code, 0);
    EXPECT_THAT(plan.output, HasSubstr("target error: 30 %"));
    EXPECT_THAT(plan.output, HasSubstr("footprint "));
    EXPECT_THAT(plan.output, HasSubstr("% by the water's mesh"));
    const Outcome dry = render(scratch, "out", {"--dry-run"});
    EXPECT_EQ(dry.code, 0);
    EXPECT_THAT(dry.output, HasSubstr("target error: 30 %: map_resolution "));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
}

#if DAPPLE_LONG
TEST(TargetError, SaysWhereItIsMissed) {
    const ScratchFolder scratch;
    const char* strict = "caustics={method: caustic_mesh, target_error: 0.1 %}";  // on eight cells a wave
    const Outcome missed = render(scratch, "out", {"-f", "2", "--strict"}, strict);
    EXPECT_EQ(missed.code, 6) << missed.output;
    EXPECT_THAT(missed.output, HasSubstr("WARNING target error: 0.1 %"));
    EXPECT_THAT(missed.output, HasSubstr("a finer mesh of the water would"));
    const Outcome memory = render(scratch, "other", {"-f", "2", "--max-memory", "40M"}, strict);
    EXPECT_EQ(memory.code, 33) << memory.output;
    EXPECT_THAT(memory.output, HasSubstr("caustics.target_error: a map_resolution of "));
}
#endif

}  // namespace
}  // namespace dapple::end_to_end
