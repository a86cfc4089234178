#include "run/memory_budget.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace dapple::run {
namespace {

TEST(MemoryBudget, ReadsAmounts) {
    EXPECT_EQ(parse_bytes("1"), 1U);
    EXPECT_EQ(parse_bytes("12345B"), 12345U);
    EXPECT_EQ(parse_bytes("4k"), 4096U);
    EXPECT_EQ(parse_bytes("512 MiB"), 512U << 20);
    EXPECT_EQ(parse_bytes("8G"), std::uint64_t{8} << 30);
    EXPECT_EQ(parse_bytes("1.5gb"), std::uint64_t{3} << 29);
    EXPECT_EQ(parse_bytes("2T"), std::uint64_t{2} << 40);
}

TEST(MemoryBudget, RefusesOtherTexts) {
    for (const char* text : {"", "0", "-1", "G", "8X", "8GG", "8 G B", "nan", "inf", "1e30", "0.1"}) {
        try {
            parse_bytes(text);
            ADD_FAILURE() << text;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::usage);
        }
    }
}

TEST(MemoryBudget, PrintsAmounts) {
    EXPECT_EQ(format_bytes(1023), "1023 B");
    EXPECT_EQ(format_bytes(1024), "1.0 KiB");
    EXPECT_EQ(format_bytes(3.25 * 1073741824.0), "3.2 GiB");
    EXPECT_EQ(format_bytes(0x1p80), "1073741824.0 PiB");
}

TEST(MemoryBudget, DefaultLeavesAQuarterOfTheMachine) {
    const std::uint64_t budget = default_memory_budget();
    EXPECT_GT(budget, std::uint64_t{64} << 20);
    EXPECT_LT(budget, std::uint64_t{1} << 50);
}

}  // namespace
}  // namespace dapple::run
