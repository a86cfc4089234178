#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "base/error.h"
#include "base/hash.h"
#include "image/exr.h"
#include "image/sample_image.h"
#include "image/temporary_folder.h"

namespace dapple::image {
namespace {

using test::run_program;
using test::sample_image;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string failure_of(const std::function<void()>& reading) {
    try {
        reading();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        return error.what();
    }
    return {};
}

std::string failure_of_decoding(std::span<const std::byte> bytes) {
    return failure_of([&] { decode_exr(bytes, "shot.exr"); });
}

std::size_t place_of(const std::vector<std::byte>& bytes, std::string_view text) {
    const auto found = std::search(bytes.begin(), bytes.end(), text.begin(), text.end(),
                                   [](std::byte b, char c) { return b == static_cast<std::byte>(c); });
    return static_cast<std::size_t>(found - bytes.begin());
}

bool same_pixels(const Image& a, const Image& b) {
    return std::ranges::all_of(a.channels, [&](const Channel& channel) {
        const Channel* other = b.find(channel.name);
        return other != nullptr && other->values == channel.values;
    });
}

TEST(ExrDamage, EveryTruncationIsAnError) {
    const auto bytes = encode_exr(sample_image(64, 48)).bytes;
    for (std::size_t part = 0; part < 100; ++part) {
        const std::size_t size = bytes.size() * part / 100;
        EXPECT_THAT(failure_of_decoding(std::span(bytes).first(size)), StartsWith("shot.exr: ")) << size;
    }
    EXPECT_NE(failure_of_decoding(std::span(bytes).first(bytes.size() - 1)), "");
}

// Behind the header stand the table of blocks and the blocks, each under zlib's checksum: a flipped bit is
// found, or it lies in a place that the pixels do not depend on.
TEST(ExrDamage, NoFlippedBitChangesPixelsSilently) {
    const Image picture = sample_image(64, 48);
    const auto bytes = encode_exr(picture).bytes;
    const Image whole = decode_exr(bytes, "shot.exr");
    const std::size_t header_end = place_of(bytes, "screenWindowWidth") + 31;
    std::size_t found = 0;
    constexpr std::uint64_t flips = 400;
    for (std::uint64_t i = 0; i < flips; ++i) {
        auto damaged = bytes;
        const std::size_t place = header_end + hash_bits(5, 0, i, 0) % (bytes.size() - header_end);
        damaged[place] ^= static_cast<std::byte>(1u << (hash_bits(5, 0, i, 1) % 8));
        const std::string failure = failure_of(
            [&] { EXPECT_TRUE(same_pixels(whole, decode_exr(damaged, "shot.exr"))) << "byte " << place; });
        found += failure.empty() ? 0 : 1;
    }
    // Few places may go unnoticed: the table, which is rebuilt from the blocks where it is seen to be broken.
    EXPECT_GT(found, flips * 9 / 10);
}

TEST(ExrDamage, FlippedHeadersEndInErrorsOnly) {
    const auto bytes = encode_exr(sample_image(16, 8)).bytes;
    const std::size_t header_end = place_of(bytes, "screenWindowWidth") + 31;
    std::size_t found = 0;
    for (std::size_t bit = 0; bit < header_end * 8; bit += 5) {
        auto damaged = bytes;
        damaged[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
        found += failure_of_decoding(damaged).empty() ? 0 : 1;  // any other exception fails the test
    }
    EXPECT_GT(found, header_end / 5);
}

TEST(ExrDamage, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
    const auto bytes = encode_exr(sample_image(16, 8)).bytes;
    const std::size_t window =
        place_of(bytes, "dataWindow") + std::strlen("dataWindow") + 1 + std::strlen("box2i") + 1 + 4;
    const std::vector<std::vector<std::int32_t>> corners{
        {0, 0, 999'999'999, 999'999'999},
        {INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX},
        {0, 0, 16'384, 7},
        {0, 0, -1, 7},
        {5, 5, 4, 4},
        {INT32_MAX, 0, INT32_MIN, 7},
    };
    for (const auto& corner : corners) {
        auto damaged = bytes;
        std::memcpy(damaged.data() + window, corner.data(), 16);
        EXPECT_THAT(failure_of_decoding(damaged), StartsWith("shot.exr: ")) << corner[0] << " " << corner[2];
    }
    // 16384 squared fits a side but, in eight channels, not 8 GiB less a bit; its blocks are not there
    // either.
    auto damaged = bytes;
    const std::int32_t largest[4] = {0, 0, 16'383, 16'383};
    std::memcpy(damaged.data() + window, largest, 16);
    EXPECT_NE(failure_of_decoding(damaged), "");
}

TEST(ExrDamage, OtherFilesAreNamed) {
    EXPECT_THAT(failure_of_decoding({}), StartsWith("shot.exr: is no readable EXR"));
    const std::vector<std::byte> zeros(5000);
    EXPECT_THAT(failure_of_decoding(zeros), StartsWith("shot.exr: is no readable EXR"));
    EXPECT_THAT(failure_of([] { read_exr("/nonexistent/a.exr"); }), StartsWith("/nonexistent/a.exr: "));
}

TEST(ExrDamage, KindsThatAreNotReadSaySo) {
    const TemporaryFolder folder;
    Image picture = sample_image(32, 32);
    write_exr_verified(folder / "a.exr", picture);
    const std::string in = "oiiotool '" + (folder / "a.exr") + "' ";
    const std::string out = " -o '" + (folder / "b.exr") + "'";
    const auto failure = [&](const std::string& how) {
        EXPECT_EQ(run_program(in + how + out), 0) << how;
        return failure_of([&] { read_exr(folder / "b.exr"); });
    };
    EXPECT_THAT(failure("--ch R,G,B,Z --deepen"), HasSubstr("deep"));
    EXPECT_THAT(failure("--compression piz"), AllOf(HasSubstr("compression"), HasSubstr("zip")));
    EXPECT_THAT(failure("--compression b44"), HasSubstr("compression"));
    EXPECT_THAT(failure("--dup --siappend"), HasSubstr("2 parts"));
}

}  // namespace
}  // namespace dapple::image
