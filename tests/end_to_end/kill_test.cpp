// The program killed at 50 random moments.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "end_to_end/program.h"
#include "run/manifest.h"
#include "run/told_figures.h"

namespace dapple::end_to_end {
namespace {

using testing::SizeIs;
using testing_tools::ChildProcess;
using testing_tools::file_text;
using testing_tools::pictures_in;
using testing_tools::ScratchFolder;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TEST(Kill, AtAnyMomentLeavesWholeFilesAndTheSameClipAfterResume) {
    const ScratchFolder scratch;
    ASSERT_EQ(run_dapple(scratch, {"render", kSmall, "-o", scratch / "warm"}).code, 0);
    const auto start = std::chrono::steady_clock::now();
    ASSERT_EQ(run_dapple(scratch, {"render", kSmall, "-o", scratch / "whole"}).code, 0);
    double run_s = seconds_since(start);
    const auto whole = pictures_in(scratch / "whole");
    ASSERT_THAT(whole, SizeIs(12));
    const testing_tools::Told figures = testing_tools::told(scratch / "whole");
    ASSERT_THAT(figures.frames, SizeIs(6));
    const std::string video = file_text(scratch / "whole/small.mp4");

    std::mt19937 random(11);
    constexpr int kKills = 50;
    int killed = 0;
    std::size_t files_before_kills = 0;
    for (int round = 0; killed < kKills && round < 3 * kKills; ++round) {
        const std::string folder = scratch / "killed" + std::to_string(round);
        ChildProcess child(dapple({"render", kSmall, "-o", folder}));
        const double moment_s = std::uniform_real_distribution<double>(0, run_s)(random);
        std::this_thread::sleep_for(std::chrono::duration<double>(moment_s));
        child.signal(SIGKILL);
        if (child.wait() == -SIGKILL) {
            ++killed;
        } else {
            run_s = moment_s;  // the machine has more time for it than at first
        }

        if (std::filesystem::exists(folder)) {
            for (const auto& [name, content] : pictures_in(folder)) {
                ASSERT_TRUE(whole.contains(name)) << name;
                EXPECT_TRUE(content == whole.at(name)) << name;
                ++files_before_kills;
            }
        }
        if (const auto manifest = run::read_manifest(folder + "/manifest.json")) {
            for (const auto& [frame, entry] : manifest->frames) {
                const std::string name = "/small.000" + std::to_string(frame) + ".exr";
                EXPECT_TRUE(run::matches(folder + "/linear" + name, entry.linear, true)) << name;
                EXPECT_TRUE(run::matches(folder + "/graded" + name, entry.graded, true)) << name;
            }
        }
        const auto resumed = run_dapple(scratch, {"render", kSmall, "-o", folder});
        ASSERT_EQ(resumed.code, 0) << resumed.output;
        EXPECT_TRUE(pictures_in(folder) == whole);
        EXPECT_TRUE(file_text(folder + "/small.mp4") == video);
        EXPECT_EQ(testing_tools::told(folder), figures);
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
            EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
        }
        std::filesystem::remove_all(folder);
    }
    EXPECT_EQ(killed, kKills) << "the kills came too late to test anything";
    EXPECT_GE(files_before_kills, 50U) << "the kills came too early to test anything";
}

}  // namespace
}  // namespace dapple::end_to_end
