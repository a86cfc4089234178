#include "base/error.h"

#include <gtest/gtest.h>

namespace dapple {
namespace {

TEST(Clipped, KeepsWhatIsShortAndCutsToBelowOneKilobyte) {
    const std::string whole(1023, 'a');
    EXPECT_EQ(clipped(whole), whole);
    const std::string cut = clipped(whole + "b");
    EXPECT_EQ(cut, std::string(1019, 'a') + " ...");
    EXPECT_EQ(clipped("two\nlines\x7f"), "two lines ");
}

}  // namespace
}  // namespace dapple
