#include "run/preview.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image/exr.h"
#include "run/child_process.h"
#include "run/interruption.h"
#include "run/scratch_folder.h"

namespace dapple::run {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::run_program;
using testing_tools::ScratchFolder;

class PreviewTest : public testing::Test {
protected:
    /// `count` pictures, odd in both sizes: the left half of one colour, the right half white.
    PreviewRequest pictures(int count, float red, float green, float blue) const {
        PreviewRequest request{scratch / "clip.mp4", {}, {24000, 1001}};
        for (int i = 0; i < count; ++i) {
            image::Image picture;
            picture.width = 65;
            picture.height = 37;
            const std::pair<const char*, float> channels[] = {{"R", red}, {"G", green}, {"B", blue}};
            for (const auto& [name, value] : channels) {
                std::vector<float> values(picture.pixels(), value);
                for (std::size_t p = 0; p < values.size(); ++p) {
                    if (p % 65 > 32) values[p] = 1;
                }
                picture.channels.push_back({name, image::PixelType::half_float, std::move(values)});
            }
            request.pictures.push_back(scratch / "p." + std::to_string(i) + ".exr");
            image::write_exr_verified(request.pictures.back(), picture);
        }
        return request;
    }

    static bool never() { return false; }

    const Interruption interruption;  // ignores SIGPIPE
    ScratchFolder scratch;
};

TEST_F(PreviewTest, HasItsFramesRateSizeAndTags) {
    const PreviewRequest request = pictures(5, 1, 1, 1);
    const PreviewResult result = make_preview(request, never);
    ASSERT_EQ(result.state, PreviewResult::State::made) << result.reason;
    EXPECT_EQ(result.file.bytes, std::filesystem::file_size(request.path));
    const char* const entries =
        "stream=codec_name,pix_fmt,width,height,r_frame_rate,avg_frame_rate,nb_read_frames,"
        "color_range,color_space,color_transfer,color_primaries";
    const auto probe =
        run_program({"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries",
                     entries, "-of", "default=noprint_wrappers=1", request.path},
                    scratch / "probe");
    for (const char* expected :
         {"codec_name=h264", "pix_fmt=yuv420p", "width=66", "height=38", "r_frame_rate=24000/1001",
          "avg_frame_rate=24000/1001", "nb_read_frames=5", "color_range=tv", "color_space=bt709",
          "color_transfer=bt709", "color_primaries=bt709"}) {
        EXPECT_THAT(probe.output, HasSubstr(expected));
    }
    // The index before the pictures: playable while it loads.
    const std::string bytes = file_text(request.path);
    EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST_F(PreviewTest, KeepsColours) {
    // BT.709 in limited range: Y' = 16 + 219 (0.2126 R' + 0.7152 G' + 0.0722 B'), here with 8-bit 255, 128,
    // 0.
    const PreviewRequest request = pictures(2, 1, 0.5F, -3);
    ASSERT_EQ(make_preview(request, never).state, PreviewResult::State::made);
    const auto decoded = run_program({"ffmpeg", "-v", "error", "-i", request.path, "-frames:v", "1", "-f",
                                      "rawvideo", "-pix_fmt", "yuv420p", "-y", scratch / "raw"},
                                     scratch / "log");
    ASSERT_EQ(decoded.code, 0) << decoded.output;
    const std::string raw = file_text(scratch / "raw");
    ASSERT_EQ(raw.size(), 66U * 38U * 3U / 2U);
    const double luma = 16 + 219 * (0.2126 + 0.7152 * 128 / 255);
    // One code for the rounding of the conversion and one for the encoder at crf 16 on a plain picture.
    EXPECT_NEAR(static_cast<unsigned char>(raw[0]), luma, 2);
    EXPECT_NEAR(static_cast<unsigned char>(raw[66 * 38 - 1]), 235, 2) << "the padded corner is no copy";
}

TEST_F(PreviewTest, EqualPicturesMakeEqualBytes) {
    PreviewRequest request = pictures(3, 0.2F, 0.4F, 0.6F);
    const PreviewResult first = make_preview(request, never);
    request.path = scratch / "again.mp4";
    const PreviewResult second = make_preview(request, never);
    ASSERT_EQ(first.state, PreviewResult::State::made);
    EXPECT_EQ(first.file.content_hash, second.file.content_hash);
}

TEST_F(PreviewTest, WithoutAnEncoderThereIsAReasonAndNoFile) {
    PreviewRequest request = pictures(2, 0, 0, 0);
    request.encoder = "no-such-encoder";
    const PreviewResult missing = make_preview(request, never);
    EXPECT_EQ(missing.state, PreviewResult::State::failed);
    EXPECT_EQ(missing.reason, "no-such-encoder cannot be started: No such file or directory");

    request.encoder = "false";  // starts, reads nothing, fails
    const PreviewResult failing = make_preview(request, never);
    EXPECT_EQ(failing.state, PreviewResult::State::failed);
    EXPECT_THAT(failing.reason, HasSubstr("false failed"));

    request.encoder = "ffmpeg";
    request.fps = {0, 1};
    const PreviewResult refused = make_preview(request, never);
    EXPECT_EQ(refused.state, PreviewResult::State::failed);
    EXPECT_THAT(refused.reason, HasSubstr("ffmpeg failed: "));
    EXPECT_FALSE(std::filesystem::exists(request.path));
}

TEST_F(PreviewTest, AMissingPictureIsAReason) {
    PreviewRequest request = pictures(2, 0, 0, 0);
    std::filesystem::remove(request.pictures[1]);
    const PreviewResult result = make_preview(request, never);
    EXPECT_EQ(result.state, PreviewResult::State::failed);
    EXPECT_THAT(result.reason, HasSubstr("p.1.exr"));
}

TEST_F(PreviewTest, StopsBetweenPicturesAndLeavesNothing) {
    const PreviewRequest request = pictures(3, 0, 0, 0);
    int asked = 0;
    const PreviewResult result = make_preview(request, [&] { return ++asked == 3; });
    EXPECT_EQ(result.state, PreviewResult::State::stopped);
    for (const auto& entry : std::filesystem::directory_iterator(scratch / ".")) {
        EXPECT_EQ(entry.path().extension(), ".exr") << entry.path();
    }
}

}  // namespace
}  // namespace dapple::run
