#include "base/suggest.h"

#include <gtest/gtest.h>

#include <string>

namespace dapple {
namespace {

TEST(Suggest, CountsEdits) {
    EXPECT_EQ(edit_distance("", ""), 0U);
    EXPECT_EQ(edit_distance("abc", ""), 3U);
    EXPECT_EQ(edit_distance("", "abc"), 3U);
    EXPECT_EQ(edit_distance("camera", "camera"), 0U);
    EXPECT_EQ(edit_distance("camera", "camra"), 1U);    // removed
    EXPECT_EQ(edit_distance("camera", "cammera"), 1U);  // inserted
    EXPECT_EQ(edit_distance("camera", "kamera"), 1U);   // replaced
    EXPECT_EQ(edit_distance("camera", "cmaera"), 1U);   // swapped
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
    EXPECT_EQ(edit_distance("ca", "abc"), 3U);  // no stretch is edited twice
}

TEST(Suggest, FindsWhatWasMeant) {
    EXPECT_EQ(nearest("positon", {"projection", "position", "target"}), "position");
    EXPECT_EQ(nearest("Refractive-Index", {"refractive_index"}), "refractive_index");
    EXPECT_EQ(nearest("fov", {"field_of_view", "up"}), "");
    EXPECT_EQ(nearest("us", {"up", "position"}), "up");
    EXPECT_EQ(nearest("xy", {"up"}), "");  // short words must be nearer
    EXPECT_EQ(nearest(std::string(1000, 'x'), {"x"}), "");
    EXPECT_EQ(nearest("", {"x"}), "");
}

TEST(Suggest, MakesSentences) {
    EXPECT_EQ(suggestion("sunn", {"sun", "point"}), "; did you mean 'sun'?");
    EXPECT_EQ(suggestion("area", {"sun", "point"}), "; expected one of: sun, point");
    EXPECT_EQ(suggestion("area", {"sun", "point"}, "there are:"), "; there are: sun, point");
}

}  // namespace
}  // namespace dapple
