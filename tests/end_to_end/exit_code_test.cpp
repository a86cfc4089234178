// Each fault has its exit code, one clear error line, and leaves nothing behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "end_to_end/program.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::pictures_in;
using testing_tools::run_program;
using testing_tools::ScratchFolder;

class ExitCode : public testing::Test {
protected:
    /// Arguments of `render` on small.yaml into scratch/out.
    testing_tools::Outcome render(std::vector<std::string> more) {
        std::vector<std::string> arguments = {"render", kSmall, "-o", scratch / "out"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_dapple(scratch, arguments);
    }

    /// The code, one line that begins with it, and its text.
    static void expect_failure(const testing_tools::Outcome& outcome, int code, const std::string& text) {
        EXPECT_EQ(outcome.code, code) << outcome.output;
        EXPECT_THAT(outcome.output, HasSubstr(text));
        const std::string prefix = "ERROR [" + std::to_string(code) + "] ";
        const std::size_t at = outcome.output.rfind(prefix);
        ASSERT_NE(at, std::string::npos) << outcome.output;
        EXPECT_TRUE(at == 0 || outcome.output[at - 1] == '\n');
        EXPECT_EQ(outcome.output.find('\n', at), outcome.output.size() - 1)
            << "more than one line: " << outcome.output;
        EXPECT_EQ(outcome.output.find(prefix), at) << "more than one error: " << outcome.output;
    }

    void expect_nothing_written() const { EXPECT_FALSE(std::filesystem::exists(scratch / "out")); }

    ScratchFolder scratch;
};

TEST_F(ExitCode, Of2IsAWrongCall) {
    expect_failure(run_dapple(scratch, {}), 2, "a verb is missing");
    expect_failure(run_dapple(scratch, {"rendr"}), 2,
                   "unknown verb 'rendr'; there are render, validate, probe, check, compare, bench and info");
    expect_failure(run_dapple(scratch, {"render"}), 2, "timeline is required");
    expect_failure(run_dapple(scratch, {"render", kSmall, "--colour"}), 2, "--colour");
    expect_failure(render({"-f", "1:3"}), 2, "write 1-10x2");
    expect_failure(render({"-f", "1-1000000000000"}), 2, "more than 10000000 frames");
    expect_failure(render({"--existing", "maybe"}), 2, "verify,skip,overwrite,error");
    expect_failure(render({"--max-memory", "much"}), 2, "write 8G");
    expect_failure(render({"--threads", "-1"}), 2, "--threads");
    for (const std::string degrees : {"0.9", "1001", "nan", "inf"}) {
        expect_failure(run_dapple(scratch, {"check", ".", "--ppd", degrees}), 2, "--ppd");
    }
    expect_nothing_written();
}

TEST_F(ExitCode, Of2IsAnotherJobsFolder) {
    ASSERT_EQ(render({"-f", "1"}).code, 0);
    const auto before = pictures_in(scratch / "out");
    expect_failure(render({"-f", "1", "--set", "clip.seed=4"}), 2,
                   "frames of another job (other: the timeline)");
    EXPECT_TRUE(pictures_in(scratch / "out") == before);
    expect_failure(render({"-f", "1", "--existing", "error"}), 2, "frame 1 exists");
    EXPECT_EQ(render({"-f", "1", "--set", "clip.seed=4", "--existing", "overwrite"}).code, 0);
}

TEST_F(ExitCode, Of3IsAnInvalidTimeline) {
    expect_failure(run_dapple(scratch, {"render", kFolder + "/broken.yaml", "-o", scratch / "out"}), 3,
                   "broken.yaml:");
    expect_failure(run_dapple(scratch, {"validate", kFolder + "/broken.yaml"}), 3, "broken.yaml:");
    expect_failure(render({"--set", "clip.nmae=x"}), 3, "did you mean 'name'?");
    expect_failure(render({"--set", "clip.resolution=[0, 36]"}), 3, "clip.resolution");
    expect_failure(render({"--set", "clip.frames=1-1000000000000"}), 3, "clip.frames");
    // All faults at once.
    const auto both = render({"--set", "clip.nmae=x", "--set", "clip.resolution=[0, 36]"});
    expect_failure(both, 3, "2 faults");
    EXPECT_THAT(both.output, HasSubstr("clip.nmae"));
    EXPECT_THAT(both.output, HasSubstr("clip.resolution"));
    expect_nothing_written();
}

TEST_F(ExitCode, Of4IsAnUnreadableInput) {
    expect_failure(run_dapple(scratch, {"render", scratch / "none.yaml"}), 4, "none.yaml");
    expect_failure(render({"--set", "objects[0].material.texture=none.png"}), 4, "none.png: cannot be read");
    expect_failure(run_dapple(scratch, {"validate", kSmall, "--set", "objects[1].file=none.obj"}), 4,
                   "none.obj");
    const std::string lamp = "lights=[{type: spot, target: [0, 0, 0], texture: ";
    expect_failure(run_dapple(scratch, {"validate", kSmall, "--set", lamp + "roof.obj}]"}), 4,
                   "roof.obj: a texture is an EXR or a PNG file");
    expect_nothing_written();
    const auto outcome = render({"--set", "objects[1].file=broken.obj"});
    expect_failure(outcome, 4, "broken.obj");
    EXPECT_TRUE(pictures_in(scratch / "out").empty());
    // What failed does not stand in the way of the right call.
    EXPECT_EQ(render({"-f", "1"}).code, 0);
}

TEST_F(ExitCode, Of5IsAnUnwritableOutput) {
    std::ofstream(scratch / "file") << "text";
    const auto below_file = run_dapple(scratch, {"render", kSmall, "-o", scratch / "file/out"});
    expect_failure(below_file, 5, "file/out");
    EXPECT_EQ(file_text(scratch / "file"), "text");

    expect_failure(render({"--log-json", scratch / "no folder/log"}), 5, "no folder/log");
    expect_nothing_written();

    // A disk that is full in the middle of a frame: files end at 8 KiB.
    const auto full = run_program({"bash", "-c", "ulimit -f 8; exec \"$0\" render \"$1\" -o \"$2\"",
                                   DAPPLE_PROGRAM, kSmall, scratch / "out"},
                                  scratch / "output.txt");
    expect_failure(full, 5, "small.0001.exr");
    EXPECT_TRUE(pictures_in(scratch / "out").empty());
    EXPECT_EQ(render({"-f", "1"}).code, 0);
}

TEST_F(ExitCode, Of7IsAMissingDevice) {
    expect_failure(render({"--device", "no such device"}), 7, "no such device");
    expect_nothing_written();
}

TEST_F(ExitCode, Of33IsTooMuchMemory) {
    expect_failure(render({"--set", "clip.resolution=[16384, 16384]", "--max-memory", "32G"}), 33,
                   "more than the 32.0 GiB of --max-memory");
    expect_failure(render({"--set", "caustics.map_resolution=2147483647"}), 33, "--max-memory");
    expect_failure(render({"--max-memory", "1M"}), 33, "more than the 1.0 MiB of --max-memory");
    // The program itself, with the device's driver, is larger than that.
    expect_failure(render({"--max-memory", "64M"}), 33, "more than the 64.0 MiB of --max-memory");
    expect_failure(render({"--max-memory", "1M", "--dry-run"}), 33, "--max-memory");
    expect_nothing_written();
}

}  // namespace
}  // namespace dapple::end_to_end
