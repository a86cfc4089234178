// Kills, signals and full disks, tried on a child process that runs the frame loop with a made-up renderer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <stdlib.h>

#include <chrono>
#include <random>
#include <thread>

#include "run/child_process.h"
#include "run/manifest.h"
#include "run/scratch_folder.h"
#include "run/told_figures.h"

namespace dapple::run {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::SizeIs;
using testing_tools::ChildProcess;
using testing_tools::pictures_in;
using testing_tools::run_program;
using testing_tools::ScratchFolder;
using testing_tools::told;
using testing_tools::Told;

std::vector<std::string> fake_render(const std::string& folder, const std::string& frames,
                                     const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {FAKE_RENDER, folder, frames};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

void wait_for_file(const std::string& path) {
    for (int i = 0; i < 2000 && !std::filesystem::exists(path); ++i) std::this_thread::sleep_for(5ms);
}

/// Nothing under a final name that is not what the undisturbed run wrote; the manifest says the truth.
void expect_no_torn_file(const std::string& folder, const std::map<std::string, std::string>& undisturbed) {
    if (!std::filesystem::exists(folder)) return;
    for (const auto& [name, content] : pictures_in(folder)) {
        if (std::filesystem::path(name).filename().string().front() == '.') continue;
        ASSERT_TRUE(undisturbed.contains(name)) << name;
        EXPECT_TRUE(content == undisturbed.at(name)) << name;
    }
    const auto manifest = read_manifest(folder + "/manifest.json");
    if (!manifest) return;
    for (const auto& [frame, entry] : manifest->frames) {
        const std::string name = "/fake.000" + std::to_string(frame) + ".exr";
        EXPECT_TRUE(matches(folder + "/linear" + name, entry.linear, true)) << name;
        EXPECT_TRUE(matches(folder + "/graded" + name, entry.graded, true)) << name;
    }
}

TEST(Kill, ResumeCompletesWithTheSameBytes) {
    const ScratchFolder scratch;
    ASSERT_EQ(run_program(fake_render(scratch / "whole", "1-6"), scratch / "log").code, 0);
    const auto whole = pictures_in(scratch / "whole");
    ASSERT_THAT(whole, SizeIs(12));
    const Told figures = told(scratch / "whole");
    ASSERT_THAT(figures.frames, SizeIs(6));

    std::mt19937 random(5);
    int killed = 0;
    std::size_t finished_before_kills = 0;
    for (int round = 0; round < 10; ++round) {
        const std::string folder = scratch / "killed" + std::to_string(round);
        ChildProcess child(fake_render(folder, "1-6", {"delay=8"}));
        // The frames take 6 times 8 ms and the time of their files: so the kill meets all stages of the run.
        std::this_thread::sleep_for(
            std::chrono::microseconds(std::uniform_int_distribution<int>(0, 90000)(random)));
        child.signal(SIGKILL);
        killed += child.wait() == -SIGKILL ? 1 : 0;
        expect_no_torn_file(folder, whole);
        if (std::filesystem::exists(folder)) finished_before_kills += pictures_in(folder).size();

        ASSERT_EQ(run_program(fake_render(folder, "1-6"), scratch / "log").code, 0);
        EXPECT_TRUE(pictures_in(folder) == whole);
        EXPECT_EQ(told(folder), figures);
        std::ifstream stats(folder + "/stats.jsonl");
        int costs = 0;
        for (std::string line; std::getline(stats, line);) costs += line.find("wall_s") != line.npos ? 1 : 0;
        EXPECT_EQ(costs, 6);
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
            EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
        }
    }
    EXPECT_GE(killed, 5) << "the kills came too late to test anything";
    EXPECT_GE(finished_before_kills, 2U) << "the kills came too early to test anything";
}

TEST(Signal, TheFirstFinishesTheFrameAndEndsWith75) {
    const ScratchFolder scratch;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const std::string folder = scratch / std::to_string(signal);
        ChildProcess child(fake_render(folder, "1-6", {"delay=100"}), scratch / "log");
        wait_for_file(folder + "/linear/fake.0001.exr");
        std::this_thread::sleep_for(30ms);
        child.signal(signal);
        EXPECT_EQ(child.wait(), 75);
        EXPECT_THAT(child.output(), HasSubstr("interrupted; the same command goes on"));
        const auto manifest = read_manifest(folder + "/manifest.json");
        ASSERT_TRUE(manifest.has_value());
        EXPECT_GE(manifest->frames.size(), 1U);
        EXPECT_LT(manifest->frames.size(), 6U);
        EXPECT_THAT(pictures_in(folder), SizeIs(2 * manifest->frames.size()));
        EXPECT_EQ(run_program(fake_render(folder, "1-6"), scratch / "log").code, 0);
    }
}

TEST(Signal, TheFirstReachesAMethodThatKeepsCheckpoints) {
    const ScratchFolder scratch;
    const std::string folder = scratch / "out";
    // Ten steps of 200 ms: without the checkpoint's stop() the frame would be finished.
    ChildProcess child(fake_render(folder, "1-2", {"slow=1", "step=200"}), scratch / "log");
    wait_for_file(folder + "/checkpoint/fake.0001.partial");
    child.signal(SIGTERM);
    EXPECT_EQ(child.wait(), 75);
    EXPECT_TRUE(pictures_in(folder).empty());
    EXPECT_TRUE(std::filesystem::exists(folder + "/checkpoint/fake.0001.partial"));
    EXPECT_EQ(run_program(fake_render(folder, "1-2", {"slow=1"}), scratch / "log").code, 0);
    EXPECT_THAT(pictures_in(folder), SizeIs(4));
    EXPECT_FALSE(std::filesystem::exists(folder + "/checkpoint"));
}

TEST(Signal, TheSecondEndsAtOnce) {
    const ScratchFolder scratch;
    const std::pair<int, int> cases[] = {{SIGINT, 130}, {SIGTERM, 143}, {SIGHUP, 143}};
    for (const auto& [signal, code] : cases) {
        const std::string folder = scratch / std::to_string(signal);
        // A frame that takes a minute: only the second signal can end it sooner.
        ChildProcess child(fake_render(folder, "1-6", {"delay=60000"}));
        wait_for_file(folder + "/manifest.json");
        std::this_thread::sleep_for(30ms);
        const auto start = std::chrono::steady_clock::now();
        child.signal(SIGTERM);
        std::this_thread::sleep_for(30ms);
        child.signal(signal);
        EXPECT_EQ(child.wait(), code);
        EXPECT_LT(std::chrono::steady_clock::now() - start, 30s);
        EXPECT_TRUE(pictures_in(folder).empty());
    }
}

TEST(FullDisk, EndsWith5AndKeepsWhatIsFinished) {
    const ScratchFolder scratch;
    // Frame 3 has files of about 100 KiB, the others of some KiB.
    ASSERT_EQ(run_program(fake_render(scratch / "whole", "1-6", {"large=3"}), scratch / "log").code, 0);
    const auto whole = pictures_in(scratch / "whole");

    const auto outcome =
        run_program(fake_render(scratch / "full", "1-6", {"large=3", "fsize=20000"}), scratch / "log");
    EXPECT_EQ(outcome.code, 5);
    EXPECT_THAT(outcome.output, HasSubstr("ERROR [5]"));
    EXPECT_THAT(outcome.output, HasSubstr("fake.0003.exr"));
    expect_no_torn_file(scratch / "full", whole);
    EXPECT_THAT(read_manifest(scratch / "full/manifest.json")->frames, SizeIs(2));

    EXPECT_EQ(run_program(fake_render(scratch / "full", "1-6", {"large=3"}), scratch / "log").code, 0);
    EXPECT_TRUE(pictures_in(scratch / "full") == whole);
}

TEST(FullDisk, AFullStandardOutputDoesNotStopTheRendering) {
    const ScratchFolder scratch;
    ChildProcess child(fake_render(scratch / "out", "1-6"), "/dev/full");
    EXPECT_EQ(child.wait(), 0);
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(12));
}

TEST(Terminal, ShowsOneUpdatingLine) {
    const ScratchFolder scratch;
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_GE(terminal, 0);
    ASSERT_EQ(::grantpt(terminal), 0);
    ASSERT_EQ(::unlockpt(terminal), 0);
    const std::string name = ::ptsname(terminal);
    // Held open here, so that the text is not lost when the child closes its end.
    const int held = ::open(name.c_str(), O_RDWR | O_NOCTTY);
    ChildProcess child(fake_render(scratch / "out", "1-6"), name);
    EXPECT_EQ(child.wait(), 0);
    std::string text(8192, '\0');
    text.resize(static_cast<std::size_t>(::read(terminal, text.data(), text.size())));
    EXPECT_THAT(text, HasSubstr("\r\033[Kframe 2: "));
    EXPECT_THAT(text, HasSubstr(" left\r\033[Kframe 3: "));
    EXPECT_THAT(text, HasSubstr("6 of 6 done\r\n"));  // the terminal itself adds the carriage return
    ::close(held);
    ::close(terminal);
}

TEST(ClosedPipe, DoesNotStopTheRendering) {
    const ScratchFolder scratch;
    // The reader leaves at once, so that the first line meets a closed pipe.
    const std::string command = std::string("\"$0\" \"$1\" 1-6 delay=20 | true; echo ${PIPESTATUS[0]}");
    const auto outcome = run_program({"bash", "-c", command, FAKE_RENDER, scratch / "out"}, scratch / "log");
    EXPECT_THAT(outcome.output, HasSubstr("\n0\n"));
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(12));
}

}  // namespace
}  // namespace dapple::run
