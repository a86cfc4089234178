#include <gmock/gmock.h>

#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "spirv/test_add_one_comp.h"
#include "spirv/test_write_index_comp.h"

namespace dapple::gpu {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Validation : public ::testing::Test {
protected:
    static constexpr std::uint32_t kCount = 64;
    // A device of its own: its messages are wanted here and must not fail the program.
    Device device{{.validation = true}};
    ComputePipeline write{device, "write", test_write_index_comp, {.storage_buffers = 1, .push_bytes = 8}};
    ComputePipeline add{device, "add", test_add_one_comp, {.storage_buffers = 2, .push_bytes = 4}};
    Buffer a{device, "buffer a", kCount * 4};
    Buffer b{device, "buffer b", kCount * 4};
    FrameStats stats;

    void write_then_read(bool declare) {
        PassList passes(device);
        Bindings writing{.buffers = {&a},
                         .writes = declare ? std::vector<const Buffer*>{&a} : std::vector<const Buffer*>{}};
        writing.set_push(std::array<std::uint32_t, 2>{kCount, 1});
        passes.compute("write", write, std::move(writing), {1, 1, 1});
        Bindings reading{.buffers = {&a, &b}, .writes = {&b}};
        reading.set_push(kCount);
        passes.compute("add", add, std::move(reading), {1, 1, 1});
        passes.run(stats);
    }
};

TEST_F(Validation, AnUndeclaredWriteIsCaughtAsAHazard) {
    ASSERT_TRUE(device.validation_active());
    write_then_read(false);
    EXPECT_THAT(device.validation_messages(), Contains(HasSubstr("SYNC-HAZARD-READ-AFTER-WRITE")));
    EXPECT_THAT(device.validation_messages(), Contains(HasSubstr("buffer a")))
        << "debug names stand in messages";
}

TEST_F(Validation, DeclaredWritesAreSilent) {
    write_then_read(true);
    EXPECT_THAT(device.validation_messages(), IsEmpty());
}

}  // namespace
}  // namespace dapple::gpu
