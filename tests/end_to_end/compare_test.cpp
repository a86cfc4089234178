// dapple compare as a program: what it prints and how it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "end_to_end/program.h"
#include "image/exr.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing_tools::Outcome;
using testing_tools::ScratchFolder;

class CompareProgramTest : public testing::Test {
protected:
    CompareProgramTest() {
        for (int frame = 1; frame <= 3; ++frame) {
            for (const auto& [name, width, value] :
                 {std::tuple{"a", 40, 0.2f}, {"b", 40, 0.3f}, {"wide", 44, 0.3f}}) {
                image::Image picture;
                picture.width = width;
                picture.height = 20;
                for (const char* channel : {"R", "G", "B"}) {
                    picture.channels.push_back(
                        {channel, image::PixelType::float32, std::vector<float>(picture.pixels(), value)});
                }
                image::write_exr_verified(scratch / name + "." + std::to_string(frame) + ".exr", picture);
            }
        }
    }
    Outcome compare(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), "compare");
        return run_dapple(scratch, arguments);
    }
    std::string clip(const std::string& name) const { return scratch / name + ".%d.exr"; }

    ScratchFolder scratch;
};

TEST_F(CompareProgramTest, WritesVideoAndSheet) {
    const Outcome run = compare({clip("a"), clip("b"), "-o", scratch / "v.mp4", "--sheet", scratch / "s.png",
                                 "--fps", "29.97", "--labels", "before,after", "--parts", "side,difference",
                                 "--difference-scale", "0.7"});
    EXPECT_EQ(run.code, 0) << run.output;
    EXPECT_THAT(run.output, HasSubstr("A before, B after"));
    EXPECT_THAT(run.output, HasSubstr("full scale 0.7 of the mean luminance of A, 0.2"));
    EXPECT_THAT(run.output, HasSubstr("v.mp4: 3 frames, 30 a second"));  // 29.97 in three digits
    EXPECT_TRUE(std::filesystem::exists(scratch / "v.mp4"));
    EXPECT_TRUE(std::filesystem::exists(scratch / "s.png"));
}

TEST_F(CompareProgramTest, EndsAsTheConventionsSay) {
    const std::string a = clip("a"), b = clip("b"), out = scratch / "v.mp4";
    const auto expect = [&](int code, const std::string& message, const std::vector<std::string>& arguments) {
        const Outcome run = compare(arguments);
        EXPECT_EQ(run.code, code) << run.output;
        EXPECT_THAT(run.output, HasSubstr("ERROR [" + std::to_string(code) + "] "));
        EXPECT_THAT(run.output, HasSubstr(message));
    };
    expect(2, "nothing is asked for", {a, b});
    expect(2, "", {a, "-o", out});
    expect(2, "--parts takes side, wipe", {a, b, "-o", out, "--parts", "side,sound"});
    expect(2, "--fps is 0.01 to 1000", {a, b, "-o", out, "--fps", "24/0"});
    expect(2, "no such view", {a, b, "-o", out, "--view", "no such view"});
    expect(2, "need as many labels", {a, b, "-o", out, "--labels", "one"});
    expect(4, "no file is called", {a, clip("none"), "-o", out});
    expect(4, "is 40 x 20", {a, clip("wide"), "-o", out});
    expect(4, "", {a, b, "-o", out, "--config", scratch / "none.ocio"});
    expect(4, "has none of the frames", {a, b, "-o", out, "-f", "10-12"});
    expect(5, "there is no folder", {a, b, "-o", scratch / "none/v.mp4"});
    EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(CompareProgramTest, InterruptedItLeavesNothing) {
    // Long enough to be caught at work: 4000 blanks are quickly drawn, but not within the time of a signal.
    testing_tools::ChildProcess child(
        dapple({"compare", clip("a"), clip("b"), "-o", scratch / "v.mp4", "-f", "1-4000"}), scratch / "log");
    for (int i = 0; i < 6000 && child.output().find("comparing") == std::string::npos; ++i) ::usleep(10000);
    child.signal(SIGINT);
    EXPECT_EQ(child.wait(), 75) << child.output();
    EXPECT_THAT(child.output(), HasSubstr("ERROR [75] interrupted: nothing was written"));
    for (const auto& entry : std::filesystem::directory_iterator(scratch / ".")) {
        EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("v.mp4")));
    }
}

}  // namespace
}  // namespace dapple::end_to_end
