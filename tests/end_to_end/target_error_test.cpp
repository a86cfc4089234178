// caustics.target_error through the whole program: settings are chosen once, and every frame has them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "end_to_end/program.h"

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

}  // namespace
}  // namespace dapple::end_to_end
