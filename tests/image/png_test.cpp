#include "image/png.h"

#include <gmock/gmock.h>

#include <limits>

#include "base/error.h"
#include "base/hash.h"
#include "image/code_values.h"
#include "image/temporary_folder.h"

namespace dapple::image {
namespace {

using test::run_program;
using test::TemporaryFolder;
using testing::Each;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::StartsWith;

std::string failure_of_decoding(std::span<const std::byte> bytes) {
    try {
        decode_png(bytes, "tile.png");
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        return error.what();
    }
    return {};
}

/// A picture of 256 x 3 pixels with all codes in each channel.
std::vector<std::uint8_t> all_codes() {
    std::vector<std::uint8_t> rgb;
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 256; ++x) {
            for (int c = 0; c < 3; ++c) rgb.push_back(static_cast<std::uint8_t>(c == y ? x : 255 - x));
        }
    }
    return rgb;
}

TEST(Png, AllCodesComeBack) {
    const TemporaryFolder folder;
    const auto rgb = all_codes();
    write_png(folder / "a.png", 256, 3, rgb);
    const CodeValues read = decode_png(read_whole_file(folder / "a.png"), "a");
    EXPECT_EQ(read.width, 256);
    EXPECT_EQ(read.height, 3);
    ASSERT_EQ(read.rgb.size(), rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) EXPECT_EQ(read.rgb[i], static_cast<float>(rgb[i]) / 255.0f);
    EXPECT_EQ(read.rgb[3 * 255], 1.0f);
}

TEST(Png, SamePictureSameBytes) {
    const TemporaryFolder folder;
    EXPECT_EQ(write_png(folder / "a.png", 256, 3, all_codes()).content_hash,
              write_png(folder / "b.png", 256, 3, all_codes()).content_hash);
}

TEST(Png, OtherLayoutsBecomeRgb) {
    const TemporaryFolder folder;
    const std::string file = folder / "a.png";
    const auto made = [&](const std::string& how) {
        EXPECT_EQ(run_program("oiiotool --create 2x2 " + how + " -o '" + file + "'"), 0) << how;
        return decode_png(read_whole_file(file), file).rgb;
    };
    const auto is_near = [](float value) {
        return testing::FloatNear(value, 0.5f / 65535);
    };  // 16-bit rounding
    EXPECT_THAT(made("1 --fill:color=0.25 2x2 -d uint16"), Each(is_near(0.25f)));
    const std::vector<float> blue_end = made("3 --fill:color=0.25,0.5,0.75 2x2 -d uint16");
    ASSERT_EQ(blue_end.size(), 12u);
    EXPECT_THAT(std::vector(blue_end.begin(), blue_end.begin() + 3),
                ElementsAre(is_near(0.25f), is_near(0.5f), is_near(0.75f)));
    // Alpha is dropped; oiiotool divides the colour by it on writing, so the file holds 0.5.
    EXPECT_THAT(made("4 --fill:color=0.25,0.25,0.25,0.5 2x2 -d uint16"), Each(is_near(0.5f)));
}

TEST(Png, DamageIsAnError) {
    const TemporaryFolder folder;
    write_png(folder / "a.png", 256, 3, all_codes());
    const auto bytes = read_whole_file(folder / "a.png");
    for (std::size_t part = 0; part < 50; ++part) {
        const std::size_t size = bytes.size() * part / 50;
        EXPECT_THAT(failure_of_decoding(std::span(bytes).first(size)),
                    StartsWith("tile.png: is no readable PNG"));
    }
    // Every chunk has a checksum: a flipped bit of a chunk that must be understood cannot pass.
    const CodeValues whole = decode_png(bytes, "a");
    std::size_t found = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        auto damaged = bytes;
        damaged[hash_bits(9, 0, i, 0) % bytes.size()] ^=
            static_cast<std::byte>(1u << (hash_bits(9, 0, i, 1) % 8));
        try {
            EXPECT_EQ(decode_png(damaged, "tile.png").rgb, whole.rgb);
        } catch (const Error&) {
            ++found;
        }
    }
    EXPECT_GT(found, 150u);
}

TEST(Png, AbsurdSizesAreRefused) {
    const TemporaryFolder folder;
    write_png(folder / "a.png", 256, 3, all_codes());
    auto bytes = read_whole_file(folder / "a.png");
    // Width in the header, big-endian, at byte 16. Its checksum would fail too, but the size is judged by its
    // own.
    for (int i = 0; i < 4; ++i) bytes[16 + static_cast<std::size_t>(i)] = std::byte{0x7f};
    EXPECT_NE(failure_of_decoding(bytes), "");
}

TEST(Png, UnwritableFolderIsAnOutputError) {
    const std::vector<std::uint8_t> rgb(3);
    try {
        write_png("/nonexistent/a.png", 1, 1, rgb);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::output_unwritable);
    }
}

TEST(CodeValues, RoundAndHold) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    Image picture;
    picture.width = 2;
    picture.height = 2;
    picture.add("B").values = {0, 0.5f, 1, 2};
    picture.add("R").values = {-1, nan, infinity, -infinity};
    picture.add("G").values = {0.49f / 255, 0.51f / 255, 254.49f / 255, 254.51f / 255};
    EXPECT_THAT(to_rgb8(picture), ElementsAreArray({0, 0, 0, 0, 1, 128, 255, 254, 255, 0, 255, 255}));
    EXPECT_THAT(to_rgb16(picture),
                ElementsAreArray({0, 126, 0, 0, 131, 32768, 65535, 65404, 65535, 0, 65409, 65535}));
}

}  // namespace
}  // namespace dapple::image
