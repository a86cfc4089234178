#include <gtest/gtest.h>

#include <stdexcept>

#include "base/error.h"
#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "spirv/test_add_one_comp.h"
#include "spirv/test_write_index_comp.h"

namespace dapple::gpu {
namespace {

struct WritePush {
    std::uint32_t count;
    std::uint32_t factor;
};

class Compute : public ::testing::Test {
protected:
    static constexpr std::uint32_t kCount = 1000;  // not a multiple of the work group
    Device& device = test::validated_device();
    ComputePipeline write{device, "write", test_write_index_comp, {.storage_buffers = 1, .push_bytes = 8}};
    ComputePipeline add{device, "add", test_add_one_comp, {.storage_buffers = 2, .push_bytes = 4}};
    FrameStats stats;

    static Bindings writing(const Buffer& values, std::uint32_t factor) {
        Bindings bindings{.buffers = {&values}, .writes = {&values}};
        bindings.set_push(WritePush{kCount, factor});
        return bindings;
    }
    static Bindings adding(const Buffer& from, const Buffer& to) {
        Bindings bindings{.buffers = {&from, &to}, .writes = {&to}};
        bindings.set_push(kCount);
        return bindings;
    }
    static constexpr std::array<std::uint32_t, 3> kGroups = {(kCount + 63) / 64, 1, 1};
};

TEST_F(Compute, WritesABufferThatTheHostReads) {
    Buffer values(device, "values", kCount * 4);
    PassList passes(device);
    passes.compute("write", write, writing(values, 3), kGroups);
    passes.run(stats);
    for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(values.as<std::uint32_t>()[i], 3 * i);
}

TEST_F(Compute, PassesRunInOrderAndSeeEarlierResults) {
    Buffer a(device, "a", kCount * 4);
    Buffer b(device, "b", kCount * 4);
    PassList passes(device);
    passes.compute("write", write, writing(a, 5), kGroups);
    passes.compute("add", add, adding(a, b), kGroups);       // reads what was written
    passes.compute("add", add, adding(b, a), kGroups);       // overwrites what was read
    passes.compute("write", write, writing(b, 7), kGroups);  // overwrites what was read and written
    passes.run(stats);
    for (std::uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(a.as<std::uint32_t>()[i], 5 * i + 2);
        ASSERT_EQ(b.as<std::uint32_t>()[i], 7 * i);
    }
}

TEST_F(Compute, WritesWaitForEarlierReads) {
    Buffer a(device, "a", kCount * 4);
    Buffer b(device, "b", kCount * 4);
    for (std::uint32_t i = 0; i < kCount; ++i) a.as<std::uint32_t>()[i] = 11 * i;
    PassList passes(device);
    passes.compute("add", add, adding(a, b), kGroups);
    passes.compute("write", write, writing(a, 7), kGroups);  // without order, b might see it
    passes.run(stats);
    for (std::uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(a.as<std::uint32_t>()[i], 7 * i);
        ASSERT_EQ(b.as<std::uint32_t>()[i], 11 * i + 1);
    }
}

TEST_F(Compute, ReadsWhatTheHostAndEarlierListsWrote) {
    Buffer a(device, "a", kCount * 4);
    Buffer b(device, "b", kCount * 4);
    for (std::uint32_t i = 0; i < kCount; ++i) a.as<std::uint32_t>()[i] = 11 * i;
    PassList passes(device);
    passes.compute("add", add, adding(a, b), kGroups);
    passes.run(stats);
    passes.compute("add", add, adding(b, a), kGroups);  // the list is empty again and may be used again
    passes.run(stats);
    for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(a.as<std::uint32_t>()[i], 11 * i + 2);
}

TEST_F(Compute, PassTimesAddUpToTheRun) {
    Buffer a(device, "a", kCount * 4);
    Buffer b(device, "b", kCount * 4);
    PassList passes(device);
    passes.compute("first", write, writing(a, 1), kGroups);
    passes.compute("second", add, adding(a, b), kGroups);
    const double start_s = wall_seconds();
    passes.run(stats);
    const double run_s = wall_seconds() - start_s;
    ASSERT_EQ(stats.passes().size(), 2u);
    EXPECT_EQ(stats.passes()[0].name, "first");
    EXPECT_EQ(stats.passes()[1].name, "second");
    const double device_s = stats.passes()[0].device_s + stats.passes()[1].device_s;
    const double wall_s = stats.passes()[0].wall_s + stats.passes()[1].wall_s;
    EXPECT_GT(device_s, 0);
    EXPECT_LE(device_s, wall_s);
    EXPECT_LE(wall_s, run_s);
}

TEST_F(Compute, MovedAndEmptyBuffersKeepTheirPlace) {
    Buffer values(device, "values", kCount * 4);
    PassList passes(device);
    passes.compute("write", write, writing(values, 2), kGroups);
    Buffer moved = std::move(values);  // passes refer to the memory, not to the object that owns it
    passes.run(stats);
    EXPECT_EQ(moved.as<std::uint32_t>()[10], 20u);
    Buffer empty(device, "empty", 0);
    EXPECT_EQ(empty.bytes(), 0u);
    EXPECT_TRUE(empty.as<float>().empty());
}

TEST_F(Compute, WrongBindingsAreRefusedWithASentence) {
    Buffer values(device, "values", kCount * 4);
    Buffer other(device, "other", 16);
    PassList passes(device);
    EXPECT_THROW(passes.compute("no push", write, {.buffers = {&values}, .writes = {&values}}, kGroups),
                 std::logic_error);
    EXPECT_THROW(passes.compute("two buffers", write, adding(values, other), kGroups), std::logic_error);
    Bindings unbound = writing(values, 1);
    unbound.writes = {&other};
    EXPECT_THROW(passes.compute("unbound write", write, unbound, kGroups), std::logic_error);
    EXPECT_THROW(passes.compute("groups", write, writing(values, 1), {1u << 31, 1, 1}), std::logic_error);
}

TEST_F(Compute, AbsurdSizesAreRefused) {
    try {
        const Buffer absurd(device, "absurd", std::size_t{1} << 50);
        FAIL() << "made";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::device);
        EXPECT_NE(std::string(error.what()).find("'absurd'"), std::string::npos) << error.what();
    }
}

TEST_F(Compute, BuffersBeyondOneBindingAreRefused) {
    if (device.largest_storage_range() > 1u << 28)
        GTEST_SKIP() << "the device binds more than the test would take";
    const Buffer large(device, "large", static_cast<std::size_t>(device.largest_storage_range()) + 4);
    PassList passes(device);
    try {
        passes.compute("write", write, writing(large, 1), kGroups);
        FAIL() << "bound";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::device);
        EXPECT_NE(std::string(error.what()).find("'large'"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace dapple::gpu
