#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple::timeline {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(DAPPLE_SOURCE_DIR) / "tests" / "input" / "broken";

std::string contents(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> broken_timelines() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(kFolder))
        if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Each tests/input/broken/NAME.yaml against NAME.expected, which holds all that a person would read.
class BrokenTimeline : public testing::TestWithParam<std::string> {};

TEST_P(BrokenTimeline, SaysWhatIsWrongAndWhere) {
    const std::string name = GetParam() + ".yaml";
    const std::string text = contents(kFolder / name);
    const std::string expected = contents(kFolder / (GetParam() + ".expected"));
    ASSERT_FALSE(expected.empty());
    try {
        Timeline::parse(text, name, kFolder.string());
        FAIL() << "no fault was found";
    } catch (const TimelineError& error) {
        EXPECT_EQ(to_string(error), expected);
        EXPECT_EQ(error.code(), ExitCode::timeline_invalid);
        for (const Fault& fault : error.faults())  // the source line stands in the file, verbatim
            EXPECT_NE(text.find(fault.source.substr(0, fault.source.find("..."))), std::string::npos);
    }
}

INSTANTIATE_TEST_SUITE_P(All, BrokenTimeline, testing::ValuesIn(broken_timelines()),
                         [](const auto& test) { return test.param; });

TEST(BrokenTimelines, AreMany) {
    EXPECT_GE(broken_timelines().size(), 25U);
}

TEST(Faults, AreCapped) {
    std::string text = "dapple: 1\nsky:\n";
    for (int i = 0; i < 70; ++i) text += "  nonsense" + std::to_string(i) + ": 1\n";
    try {
        Timeline::parse(text, "many.yaml", ".");
        FAIL() << "no fault was found";
    } catch (const TimelineError& error) {
        EXPECT_EQ(error.faults().size(), 50U);
        EXPECT_EQ(error.more(), 20U);
        const std::string all = to_string(error);
        EXPECT_NE(all.find("70 faults, the first 50 are shown"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("many.yaml:3:3: sky.nonsense0: "), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("(and 69 more faults)"), std::string::npos);
    }
}

TEST(Faults, LongLinesAreCut) {
    const std::string text = "dapple: 1\nclip: {name: \"" + std::string(5000, 'x') + "\"}\n";
    try {
        Timeline::parse(text, "long.yaml", ".");
        FAIL() << "no fault was found";
    } catch (const TimelineError& error) {
        EXPECT_LT(to_string(error).size(), 1000U);
    }
}

}  // namespace
}  // namespace dapple::timeline
