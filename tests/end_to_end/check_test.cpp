// The verb on a clip that was rendered by the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "end_to_end/program.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::ScratchFolder;

class CheckVerb : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(run_dapple(scratch, {"render", kSmall, "-o", scratch / "out"}).code, 0);
    }
    testing_tools::Outcome check(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "check");
        return run_dapple(scratch, arguments);
    }
    std::string first_picture() const {
        std::string first;
        for (const auto& entry : std::filesystem::directory_iterator(scratch / "out/linear")) {
            if (first.empty() || entry.path().string() < first) first = entry.path().string();
        }
        return first;
    }
    ScratchFolder scratch;
};

TEST_F(CheckVerb, PassesACleanClipAndPrintsJson) {
    const auto clean = check({scratch / "out", "--reference", scratch / "out/manifest.json"});
    EXPECT_EQ(clean.code, 0) << clean.output;
    EXPECT_THAT(clean.output, HasSubstr("clean: nothing found"));
    const auto json = check({scratch / "out", "--graded", "--reference", scratch / "out", "--json"});
    EXPECT_EQ(json.code, 0) << json.output;
    const auto figures = nlohmann::json::parse(json.output);
    EXPECT_EQ(figures.at("clip").at("flip"), 0.0);
    EXPECT_EQ(figures.at("clip").at("flip_kind"), "ldr");
    EXPECT_TRUE(figures.at("seconds").contains("cpu_decoding"));
    EXPECT_EQ(check({scratch / "out", "--layer", "caustics"}).code, 0);
}

TEST_F(CheckVerb, FindingsAre6AndBadCallsAre2Or4) {
    const std::string picture = first_picture();
    const std::string whole = file_text(picture);
    std::ofstream(picture, std::ios::binary) << whole.substr(0, whole.size() / 2);
    const auto damaged = check({scratch / "out", "--html", scratch / "page.html"});
    EXPECT_EQ(damaged.code, 6) << damaged.output;
    EXPECT_THAT(damaged.output, HasSubstr("(damaged): "));
    EXPECT_THAT(damaged.output, HasSubstr("ERROR [6] "));
    EXPECT_THAT(file_text(scratch / "page.html"), HasSubstr("(damaged): "));

    EXPECT_EQ(check({scratch / "nowhere"}).code, 4);
    EXPECT_EQ(check({picture}).code, 4);
    EXPECT_EQ(check({scratch / "out", "--layer", "nothing"}).code, 4);
    EXPECT_EQ(check({}).code, 2);
    EXPECT_EQ(check({scratch / "out", "--max-flicker", "nan"}).code, 2);
    EXPECT_EQ(check({scratch / "out", "--max-error", "0.1"}).code, 2);
    EXPECT_EQ(check({scratch / "out", "--frames", "1:3"}).code, 2);
    EXPECT_EQ(check({scratch / "out", "--exposures", "1,2"}).code, 2);
}

}  // namespace
}  // namespace dapple::end_to_end
