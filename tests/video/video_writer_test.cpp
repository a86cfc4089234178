#include "video/video_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "base/error.h"
#include "run/child_process.h"
#include "run/scratch_folder.h"

namespace dapple::video {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::run_program;
using testing_tools::ScratchFolder;

class VideoWriterTest : public testing::Test {
protected:
    VideoWriterTest() { ::signal(SIGPIPE, SIG_IGN); }
    ~VideoWriterTest() override { ::signal(SIGPIPE, SIG_DFL); }

    static std::vector<std::uint8_t> plain(const VideoFormat& format, std::uint8_t red, std::uint8_t green,
                                           std::uint8_t blue) {
        std::vector<std::uint8_t> rgb;
        for (int i = 0; i < format.width * format.height; ++i) rgb.insert(rgb.end(), {red, green, blue});
        return rgb;
    }
    std::string script(const std::string& text) const {
        const std::string path = scratch / "encoder";
        std::ofstream(path) << "#!/bin/sh\n" << text;
        std::filesystem::permissions(path, std::filesystem::perms::owner_all);
        return path;
    }
    std::size_t files() const {
        std::size_t count = 0;
        for (const auto& entry : std::filesystem::directory_iterator(scratch / ".")) {
            count += entry.path().filename() != "encoder";
        }
        return count;
    }

    ScratchFolder scratch;
};

TEST_F(VideoWriterTest, OddSizesGrowByACopyOfTheLastPixels) {
    const VideoFormat format{5, 3, 25, 1};
    VideoWriter writer(scratch / "v.mp4", format);
    std::vector<std::uint8_t> rgb = plain(format, 0, 0, 0);
    // The right column and the lower row are white: so are their copies.
    for (std::size_t y = 0; y < 3; ++y) {
        for (std::size_t x = 0; x < 5; ++x) {
            if (x < 4 && y < 2) continue;
            for (std::size_t c = 0; c < 3; ++c) rgb[3 * (5 * y + x) + c] = 255;
        }
    }
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(writer.add(rgb));
    const WrittenFile file = writer.finish();
    EXPECT_EQ(file.bytes, std::filesystem::file_size(scratch / "v.mp4"));
    const auto decoded = run_program({"ffmpeg", "-v", "error", "-i", scratch / "v.mp4", "-frames:v", "1",
                                      "-f", "rawvideo", "-pix_fmt", "gray", "-y", scratch / "raw"},
                                     scratch / "log");
    ASSERT_EQ(decoded.code, 0) << decoded.output;
    const std::string raw = file_text(scratch / "raw");
    ASSERT_EQ(raw.size(), 6u * 4u);
    const auto luma = [&](std::size_t x, std::size_t y) {
        return static_cast<unsigned char>(raw[6 * y + x]);
    };
    // Full-range grey as ffmpeg converts it: 0 and 255, and a few codes for the encoder at crf 16.
    EXPECT_NEAR(luma(0, 0), 0, 8);
    EXPECT_NEAR(luma(5, 0), 255, 8);
    EXPECT_NEAR(luma(0, 3), 255, 8);
    EXPECT_NEAR(luma(5, 3), 255, 8);
}

TEST_F(VideoWriterTest, WithoutFinishNothingIsLeft) {
    const VideoFormat format{16, 16, 24, 1};
    {
        VideoWriter writer(scratch / "v.mp4", format);
        for (int i = 0; i < 10; ++i) EXPECT_TRUE(writer.add(plain(format, 9, 9, 9)));
        EXPECT_EQ(files(), 1u) << "the temporary";
    }
    EXPECT_EQ(files(), 0u);
}

TEST_F(VideoWriterTest, AnOlderVideoStandsUntilTheNewOneIsWhole) {
    std::ofstream(scratch / "v.mp4") << "old";
    const VideoFormat format{16, 16, 24, 1};
    VideoWriter writer(scratch / "v.mp4", format);
    EXPECT_TRUE(writer.add(plain(format, 1, 2, 3)));
    EXPECT_EQ(file_text(scratch / "v.mp4"), "old");
    writer.finish();
    EXPECT_NE(file_text(scratch / "v.mp4"), "old");
    EXPECT_EQ(files(), 1u);
}

TEST_F(VideoWriterTest, AFolderThatIsNotThereIsToldAtOnce) {
    try {
        VideoWriter writer(scratch / "none/v.mp4", {16, 16, 24, 1});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::output_unwritable);
        EXPECT_THAT(error.what(), HasSubstr("none/v.mp4: No such file or directory"));
    }
}

TEST_F(VideoWriterTest, WhatTheEncoderComplainsOfIsTold) {
    const VideoFormat format{256, 256, 24, 1};
    const auto failure = [&](const std::string& text) {
        VideoWriter writer(scratch / "v.mp4", format, script(text));
        bool fed = true;
        // A pipe holds 64 KiB, a picture has 192: the second at the latest is refused.
        for (int i = 0; i < 3 && fed; ++i) fed = writer.add(plain(format, 0, 0, 0));
        EXPECT_FALSE(fed);
        try {
            writer.finish();
        } catch (const Error& error) {
            return std::pair<ExitCode, std::string>(error.code(), error.what());
        }
        return std::pair<ExitCode, std::string>(ExitCode::done, "");
    };
    const auto broken = failure("echo 'wrong \033[31mcolour' >&2; exit 1\n");
    EXPECT_EQ(broken.first, ExitCode::failure);
    EXPECT_THAT(broken.second, HasSubstr("failed: wrong  [31mcolour"));
    const auto full = failure("echo 'out.mp4: No space left on device' >&2; exit 1\n");
    EXPECT_EQ(full.first, ExitCode::output_unwritable);
    EXPECT_THAT(failure("kill -9 $$\n").second, HasSubstr("failed"));
    EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace dapple::video
