#include "base/frame_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "base/error.h"

namespace dapple {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::int64_t> frames(const std::string& text) {
    return FrameSet::parse(text).frames();
}

std::string failure(const std::string& text) {
    try {
        FrameSet::parse(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage) << text;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << text;
        return error.what();
    }
    ADD_FAILURE() << "accepted: " << text;
    return "";
}

TEST(FrameSet, ReadsEveryForm) {
    EXPECT_THAT(frames("7"), ElementsAre(7));
    EXPECT_THAT(frames("3-6"), ElementsAre(3, 4, 5, 6));
    EXPECT_THAT(frames("3..6"), ElementsAre(3, 4, 5, 6));
    EXPECT_THAT(frames("1-10x3"), ElementsAre(1, 4, 7, 10));
    EXPECT_THAT(frames("1..10x4"), ElementsAre(1, 5, 9));
    EXPECT_THAT(frames("1-10y3"), ElementsAre(2, 3, 5, 6, 8, 9));
    EXPECT_THAT(frames("5, 1-2 ,9"), ElementsAre(5, 1, 2, 9));
    EXPECT_THAT(frames("4-4"), ElementsAre(4));
    EXPECT_THAT(frames("1-3x100"), ElementsAre(1));
}

TEST(FrameSet, ReadsNegativeAndDescendingRanges) {
    EXPECT_THAT(frames("-8--5"), ElementsAre(-8, -7, -6, -5));
    EXPECT_THAT(frames("-1-1"), ElementsAre(-1, 0, 1));
    EXPECT_THAT(frames("-2..-4"), ElementsAre(-2, -3, -4));
    EXPECT_THAT(frames("10-1x3"), ElementsAre(10, 7, 4, 1));
    EXPECT_THAT(frames("5-1y2"), ElementsAre(4, 2));
    EXPECT_THAT(frames("9223372036854775806-9223372036854775807"), ElementsAre(INT64_MAX - 1, INT64_MAX));
    EXPECT_THAT(frames("-9223372036854775808-9223372036854775807x9223372036854775807"),
                ElementsAre(INT64_MIN, -1, INT64_MAX - 1));
}

TEST(FrameSet, KeepsTheFirstOfRepeatedFrames) {
    const FrameSet set = FrameSet::parse("3,1-5,5-1");
    EXPECT_THAT(set.frames(), ElementsAre(3, 1, 2, 4, 5));
    EXPECT_EQ(set.duplicates(), 6U);
    EXPECT_EQ(FrameSet::parse("1-5").duplicates(), 0U);
}

TEST(FrameSet, SaysWhatWouldBeRight) {
    EXPECT_THAT(failure("1-10:2"), HasSubstr("write 1-10x2"));
    EXPECT_THAT(failure(""), HasSubstr("lists like 1,5,10-20x2"));
    EXPECT_THAT(failure("1,,2"), HasSubstr("a frame number is expected"));
    EXPECT_THAT(failure("1,2,"), HasSubstr("a frame number is expected"));
    EXPECT_THAT(failure("1-"), HasSubstr("the end of a range"));
    EXPECT_THAT(failure("1-10x0"), HasSubstr("step must be positive"));
    EXPECT_THAT(failure("10-1x-2"), HasSubstr("10-1x2"));
    EXPECT_THAT(failure("1-10x"), HasSubstr("a step is expected"));
    EXPECT_THAT(failure("1-10y1"), HasSubstr("no frame"));
    EXPECT_THAT(failure("5-5y2"), HasSubstr("no frame"));
    for (const char* text : {"x", "1 2", "1-2-3", "1.5", "+1", "0x10", "1-10x2y3", "1...3", "1-10 x2",
                             "1-1e3", "99999999999999999999"}) {
        EXPECT_FALSE(failure(text).empty()) << text;
    }
}

TEST(FrameSet, RefusesEndlessSetsBeforeAllocatingThem) {
    EXPECT_EQ(frames("1-10000000").size(), FrameSet::kLargest);
    for (const char* text : {"1-10000001", "1-2000000000", "1-1000000000000", "1-10000000,20000000",
                             "-9223372036854775808-9223372036854775807",
                             "-9223372036854775808-9223372036854775807y2", "1-9000000,1-9000000"}) {
        EXPECT_THAT(failure(text), HasSubstr("more than 10000000 frames")) << text;
    }
}

TEST(FrameSet, RangeMayDescend) {
    EXPECT_THAT(FrameSet::range(2, -1).frames(), ElementsAre(2, 1, 0, -1));
}

/// parse(to_string(s)) is s, for random sets in all forms.
TEST(FrameSet, RoundTrips) {
    std::mt19937 random(7);
    const auto pick = [&](int low, int high) {
        return std::uniform_int_distribution<int>(low, high)(random);
    };
    for (int trial = 0; trial < 2000; ++trial) {
        std::string text;
        for (int item = pick(1, 5); item > 0; --item) {
            if (!text.empty()) text += ',';
            text += std::to_string(pick(-30, 30));
            if (pick(0, 1) == 0) continue;
            text +=
                (pick(0, 1) != 0 ? "-" : "..") + std::to_string(pick(31, 60) * (pick(0, 1) != 0 ? 1 : -1));
            const int form = pick(0, 2);
            if (form == 1) text += 'x' + std::to_string(pick(1, 9));
            if (form == 2) text += 'y' + std::to_string(pick(2, 9));
        }
        const FrameSet set = FrameSet::parse(text);
        const std::set<std::int64_t> distinct(set.frames().begin(), set.frames().end());
        EXPECT_EQ(distinct.size(), set.frames().size()) << text;
        EXPECT_EQ(FrameSet::parse(to_string(set)).frames(), set.frames()) << text << " -> " << to_string(set);
    }
}

TEST(FrameSet, PrintsShortly) {
    EXPECT_EQ(to_string(FrameSet::parse("1,2,3,4")), "1-4");
    EXPECT_EQ(to_string(FrameSet::parse("1,3,5,7")), "1-7x2");
    EXPECT_EQ(to_string(FrameSet::parse("1,3")), "1,3");
    EXPECT_EQ(to_string(FrameSet::parse("9,8,7")), "9-7");
    EXPECT_EQ(to_string(FrameSet::parse("-9223372036854775808,9223372036854775807")),
              "-9223372036854775808,9223372036854775807");
}

}  // namespace
}  // namespace dapple
