// dapple check has nothing to say of the demo clips, small: whatever it found there would be a false alarm.
#include <gtest/gtest.h>

#include "end_to_end/program.h"
#include "source_dir.h"

namespace dapple::end_to_end {
namespace {

using testing_tools::Outcome;
using testing_tools::ScratchFolder;

class DemoClip : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Of, DemoClip,
                         testing::Values("blender_ocean", "bridge", "cascades", "deep", "denoise", "fog",
                                         "glass_mesh", "glass_sphere", "gobo", "godrays", "pool", "poolside",
                                         "seabed", "smoke"),
                         [](const auto& clip) { return std::string(clip.param); });

TEST_P(DemoClip, IsClean) {
    const ScratchFolder scratch;
    const std::string timeline = std::string(DAPPLE_SOURCE_DIR) + "/sequences/" + GetParam() + ".yaml";
    // blender_ocean has eight frames; jumps are told from six on.
    const std::string frames = GetParam() == std::string("blender_ocean") ? "1-8" : "1-12";
    const Outcome rendered = run_dapple(scratch, {"render", timeline, "-f", frames, "-o", scratch / "out",
                                                  "--set", "clip.resolution=[96, 54]"});
    ASSERT_EQ(rendered.code, 0) << rendered.output;
    const auto check = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"check", scratch / "out", "-f", frames};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_dapple(scratch, arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
    };
    check({});
    check({"--graded"});
    check({"--layer", "E"});
}

}  // namespace
}  // namespace dapple::end_to_end
