#include "grids/reader_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <random>

#include "base/error.h"
#include "grids/vdb_reply.h"
#include "source_dir.h"

namespace dapple::grids {
namespace {

using testing::HasSubstr;

std::string text_of(const ProcessOutput& output) {
    return {reinterpret_cast<const char*>(output.text.data()), output.text.size()};
}

ProcessOutput shell(const std::string& script, double seconds = 60, std::size_t most_text = 1000) {
    return run_reader({"/bin/sh", "-c", script}, seconds, most_text);
}

TEST(ReaderProcess, GivesTextAndVoxels) {
    const ProcessOutput output = shell("printf hello >&4; printf voxels >&3; echo lost; echo lost >&2");
    EXPECT_EQ(output.failure, "");
    EXPECT_EQ(text_of(output), "hello");
    ASSERT_EQ(output.voxels.size, 6U);
    EXPECT_EQ(std::memcmp(output.voxels.data.get(), "voxels", 6), 0);
}

TEST(ReaderProcess, TellsHowItEnded) {
    EXPECT_THAT(shell("kill -SEGV $$").failure, HasSubstr("signal 11"));
    EXPECT_EQ(shell("exit 3").failure, "ended with code 3");
    EXPECT_EQ(shell("exec sleep 100", 0.05).failure, "took longer than 0.05 s");
    EXPECT_EQ(shell("while :; do echo more >&4; done").failure, "said too much");
    EXPECT_EQ(shell("exit 3").voxels.size, 0U);
}

TEST(ReaderProcess, HasNothingElseOpen) {
    const int descriptor = ::fcntl(STDOUT_FILENO, F_DUPFD, 20);  // not closed on exec
    EXPECT_EQ(text_of(shell("cd /proc/self/fd && printf '%s ' [0-9]* >&4")).substr(0, 10), "0 1 2 3 4 ");
    EXPECT_EQ(text_of(shell("test -e /proc/self/fd/" + std::to_string(descriptor) + " && echo open >&4")),
              "");
    ::close(descriptor);
}

TEST(ReaderProcess, MissingProgram) {
    try {
        run_reader({"/nowhere/dapple-read-vdb"}, 1, 1);
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::failure);
        EXPECT_THAT(error.what(), HasSubstr("/nowhere/dapple-read-vdb"));
    }
}

/// Whatever stands in the memory that the reader leaves, it is refused or can be read: run with
/// AddressSanitizer to see all that this shows.
TEST(ReaderProcess, DamagedVoxelsAreRefusedOrHarmless) {
    const std::string smoke = DAPPLE_SOURCE_DIR "/sequences/assets/smoke/smoke.0001.vdb";
    const ProcessOutput output =
        run_reader({reader_program(), "read", smoke, "density", "1000000000"}, 60, 4096);
    ASSERT_EQ(output.failure, "");
    const std::size_t size = output.voxels.size;
    ASSERT_GT(size, 100000U);

    std::mt19937 random(5);
    constexpr std::size_t kHeader = 2048;  // grid, tree, root and its tiles: every bit of it counts
    const glm::dmat4 identity{1.0};
    int refused = 0;
    int read = 0;
    for (int i = 0; i < 2500; ++i) {
        const std::shared_ptr<std::byte> copy(static_cast<std::byte*>(std::aligned_alloc(32, size)),
                                              std::free);
        std::memcpy(copy.get(), output.voxels.data.get(), size);
        for (auto flips = 1 + random() % 3; flips > 0; --flips) {
            const std::size_t place = random() % (i % 2 == 0 ? kHeader : size);
            copy.get()[place] ^= std::byte{1} << (random() % 8);
        }
        // Cut buffers keep their announced size, which is wrong then.
        const std::size_t given = i % 10 == 9 ? random() % size : size;
        try {
            const auto grid = grid_of_buffer({copy, given}, identity);
            DensityGrid::Reader reader(*grid);
            for (int n = 0; n < 200; ++n) {
                const auto coordinate = [&] { return static_cast<int>(random() % 500) - 60; };
                const glm::ivec3 at(coordinate(), coordinate(), coordinate());
                ASSERT_GE(reader.voxel(at), 0);
                ASSERT_GE(reader.density(glm::dvec3(at) + 0.3), 0);
                reader.block_is_empty(at);
            }
            ++read;
        } catch (const Error& error) {
            ASSERT_EQ(error.code(), ExitCode::input_unreadable);
            ++refused;
        }
    }
    EXPECT_GT(refused, 300);
    EXPECT_GT(read, 300);  // names, unused fields, and other values
}

}  // namespace
}  // namespace dapple::grids
