#include "image/exr.h"

#include <gmock/gmock.h>

#include <bit>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "image/sample_image.h"
#include "image/temporary_folder.h"

namespace dapple::image {
namespace {

using test::run_program;
using test::sample_image;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::Pair;

Image one_channel(std::vector<float> values, PixelType type) {
    Image picture;
    picture.width = static_cast<int>(values.size());
    picture.height = 1;
    picture.channels.push_back({"Y", type, std::move(values)});
    return picture;
}

std::vector<float> stored(const std::vector<float>& values, PixelType type) {
    return decode_exr(encode_exr(one_channel(values, type)).bytes, "memory").channels.at(0).values;
}

TEST(Exr, KeepsFloatsBitByBit) {
    std::vector<float> values{0.0f,
                              -0.0f,
                              std::numeric_limits<float>::denorm_min(),
                              std::numeric_limits<float>::min(),
                              std::numeric_limits<float>::max(),
                              std::numeric_limits<float>::lowest(),
                              1e-7f};
    for (std::uint64_t i = 0; values.size() < 4000; ++i) {
        const auto value = std::bit_cast<float>(hash_bits(3, 0, i, 0));
        if (std::isfinite(value)) values.push_back(value);
    }
    const auto read = stored(values, PixelType::float32);
    ASSERT_EQ(read.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_EQ(std::bit_cast<std::uint32_t>(read[i]), std::bit_cast<std::uint32_t>(values[i]))
            << values[i];
    }
}

// IEEE 754 binary16: 11 significant bits, smallest subnormal 2^-24, ties to even.
TEST(Exr, RoundsHalvesToNearestEven) {
    const std::vector<std::pair<float, float>> cases{
        {1.0f + 0x1p-11f, 1.0f},
        {1.0f + 0x1.8p-11f, 1.0f + 0x1p-10f},
        {1.0f + 0x3p-11f, 1.0f + 0x2p-10f},
        {2049, 2048},
        {2051, 2052},
        {0x1p-24f, 0x1p-24f},
        {0x1p-25f, 0},
        {0x1.8p-25f, 0x1p-24f},
        {0x3p-25f, 0x1p-23f},
        {-0.1f, -0x1.998p-4f},
        {65504, 65504},
    };
    std::vector<float> values;
    std::vector<float> expected;
    for (const auto& [value, half] : cases) {
        values.push_back(value);
        expected.push_back(half);
    }
    EXPECT_THAT(stored(values, PixelType::half_float), ElementsAreArray(expected));
}

TEST(Exr, ClampsHalvesAndCountsThem) {
    const Image picture = one_channel({65504, 65505, -70000, 1e30f, 1, -65504}, PixelType::half_float);
    const EncodedExr encoded = encode_exr(picture);
    EXPECT_EQ(encoded.counts.clamped, 3u);
    EXPECT_EQ(encoded.counts.non_finite, 0u);
    EXPECT_THAT(decode_exr(encoded.bytes, "memory").channels.at(0).values,
                ElementsAre(65504, 65504, -65504, 65504, 1, -65504));
    EXPECT_EQ(encode_exr(one_channel({1e30f}, PixelType::float32)).counts.clamped, 0u);
}

TEST(Exr, NoNanOrInfinityReachesAFile) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    for (const PixelType type : {PixelType::half_float, PixelType::float32}) {
        const EncodedExr encoded = encode_exr(one_channel({1, nan, infinity, -infinity, 2}, type));
        EXPECT_EQ(encoded.counts.non_finite, 3u);
        EXPECT_EQ(encoded.counts.clamped, 0u);
        EXPECT_THAT(decode_exr(encoded.bytes, "memory").channels.at(0).values, ElementsAre(1, 0, 0, 0, 2));
    }
}

TEST(Exr, KeepsLayersTypesAndMetadata) {
    const Image picture = sample_image(61, 37);
    const Image read = decode_exr(encode_exr(picture).bytes, "memory");
    EXPECT_EQ(read.width, 61);
    EXPECT_EQ(read.height, 37);
    ASSERT_EQ(read.channels.size(), picture.channels.size());
    for (const Channel& channel : picture.channels) {
        const Channel* found = read.find(channel.name);
        ASSERT_NE(found, nullptr) << channel.name;
        EXPECT_EQ(found->type, channel.type) << channel.name;
        if (channel.type == PixelType::float32) {
            EXPECT_EQ(found->values, channel.values) << channel.name;
        }
    }
    EXPECT_THAT(read.metadata, ElementsAre(Pair("comments", "two\nlines, \"quoted\""),
                                           Pair("dapple:frame", "12"), Pair("owner", "")));
}

TEST(Exr, ReadsOnlyTheChannelsThatAreWanted) {
    const Image picture = sample_image(61, 37);
    const std::vector<std::byte> bytes = encode_exr(picture).bytes;
    const Image some = decode_exr(bytes, "memory", [](const std::string& name) { return name.size() == 1; });
    ASSERT_EQ(some.channels.size(), 4u);
    EXPECT_EQ(some.find("E.G"), nullptr);
    EXPECT_EQ(some.find("Z")->values, picture.find("Z")->values);
    const Image none = decode_exr(bytes, "memory", [](const std::string&) { return false; });
    EXPECT_TRUE(none.channels.empty());
    EXPECT_EQ(none.width, 61);
    EXPECT_EQ(none.metadata.size(), picture.metadata.size());
}

TEST(Exr, TellsThePrimariesOfAFile) {
    const Image picture = sample_image(5, 3);
    ExrOptions options;
    EXPECT_FALSE(decode_exr(encode_exr(picture, options).bytes, "memory").chromaticities);
    options.chromaticities = kAcesCgChromaticities;
    EXPECT_EQ(decode_exr(encode_exr(picture, options).bytes, "memory").chromaticities, kAcesCgChromaticities);
}

TEST(Exr, SameBytesOnAnyNumberOfThreads) {
    const Image picture = sample_image(200, 150);
    set_thread_count(1);
    set_exr_threads(1);
    const auto alone = encode_exr(picture).bytes;
    const auto again = encode_exr(picture).bytes;
    set_thread_count(2);
    set_exr_threads(2);
    const auto together = encode_exr(picture).bytes;
    const Image read = decode_exr(together, "memory");
    set_exr_threads(1);
    EXPECT_EQ(alone, again);
    EXPECT_EQ(alone, together);
    EXPECT_EQ(read.find("Z")->values, picture.find("Z")->values);
}

TEST(Exr, LevelOfCompressionLeavesPixelsAlone) {
    const Image picture = sample_image(200, 150);
    ExrOptions strong;
    strong.zip_level = 9;
    const auto fast = encode_exr(picture).bytes;
    const auto small = encode_exr(picture, strong).bytes;
    EXPECT_LT(small.size(), fast.size());
    EXPECT_EQ(decode_exr(small, "").find("Z")->values, decode_exr(fast, "").find("Z")->values);
}

TEST(Exr, RefusesMetadataUnderNamesOfTheFormat) {
    Image picture = sample_image(4, 4);
    picture.metadata = {{"channels", "none"}};
    EXPECT_THROW(encode_exr(picture), Error);
}

TEST(Exr, VerifiedFileHoldsTheEncodedBytes) {
    const TemporaryFolder folder;
    const Image picture = sample_image(64, 48);
    const WrittenExr written = write_exr_verified(folder / "a.exr", picture);
    const auto bytes = read_whole_file(folder / "a.exr");
    EXPECT_EQ(bytes, encode_exr(picture).bytes);
    EXPECT_EQ(written.bytes, bytes.size());
    EXPECT_EQ(written.content_hash, content_hash(bytes.data(), bytes.size()));
    EXPECT_EQ(read_exr(folder / "a.exr").find("E.G")->values, picture.find("E.G")->values);
    EXPECT_THAT(folder.names(), ElementsAre("a.exr"));
}

// The comparison behind every verified write sees the smallest difference.
TEST(Exr, HoldsItsOwnImageOnly) {
    const Image picture = sample_image(20, 10);
    const auto bytes = encode_exr(picture).bytes;
    EXPECT_TRUE(exr_holds(bytes, picture, "memory"));
    const auto holds_changed = [&](const std::function<void(Image&)>& change) {
        Image other = picture;
        change(other);
        return exr_holds(bytes, other, "memory");
    };
    EXPECT_FALSE(holds_changed(
        [](Image& i) { i.find("Z")->values[199] = std::nextafter(i.find("Z")->values[199], 1e9f); }));
    EXPECT_FALSE(holds_changed([](Image& i) { i.find("R")->values[0] += 0x1p-10f; }));
    EXPECT_TRUE(holds_changed([](Image& i) { i.find("R")->values[0] = 0.2f + 0x1p-20f; }));  // the same half
    EXPECT_FALSE(holds_changed([](Image& i) { i.find("Z")->name = "depth"; }));
    EXPECT_FALSE(holds_changed([](Image& i) { i.channels.pop_back(); }));
    EXPECT_FALSE(holds_changed([](Image& i) { i.find("R")->type = PixelType::float32; }));
    EXPECT_FALSE(holds_changed([](Image& i) { std::swap(i.width, i.height); }));
}

TEST(Exr, UnwritableFolderIsAnOutputError) {
    try {
        write_exr_verified("/nonexistent/a.exr", sample_image(4, 4));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::output_unwritable);
        EXPECT_THAT(error.what(), HasSubstr("/nonexistent/a.exr"));
    }
}

TEST(ExrWithOpenImageIo, ReadsEveryLayer) {
    const TemporaryFolder folder;
    const Image picture = sample_image(61, 37);
    write_exr_verified(folder / "a.exr", picture);
    for (const Channel& channel : picture.channels) {
        const std::string copy = folder / "copy.exr";
        ASSERT_EQ(run_program("oiiotool '" + (folder / "a.exr") + "' --ch " + channel.name +
                              " -d float -o '" + copy + "'"),
                  0)
            << channel.name;
        const Image read = read_exr(copy);
        ASSERT_EQ(read.channels.size(), 1u);
        EXPECT_EQ(read.channels[0].values,
                  decode_exr(encode_exr(picture).bytes, "").find(channel.name)->values)
            << channel.name;
    }
}

TEST(ExrWithOpenImageIo, SeesTheHeader) {
    const TemporaryFolder folder;
    ExrOptions options;
    options.chromaticities = kAcesCgChromaticities;
    options.fps_numerator = 24000;
    options.fps_denominator = 1001;
    write_exr_verified(folder / "a.exr", sample_image(8, 8), options);
    ASSERT_EQ(
        std::system(("exrheader '" + (folder / "a.exr") + "' > '" + (folder / "header.txt") + "'").c_str()),
        0);
    const auto bytes = read_whole_file(folder / "header.txt");
    const std::string header(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_THAT(header, HasSubstr("24000/1001"));
    EXPECT_THAT(header, HasSubstr("red   (0.713 0.293)"));
    EXPECT_THAT(header, HasSubstr("white (0.32168 0.33767)"));
    EXPECT_THAT(header, HasSubstr("zip, multi-scanline blocks"));
    EXPECT_THAT(header, HasSubstr("dapple:frame (type string): \"12\""));
    EXPECT_THAT(header, testing::Not(HasSubstr("capDate")));
}

TEST(ExrWithOpenImageIo, TilesAndWindowsAreRead) {
    const TemporaryFolder folder;
    const Image picture = sample_image(61, 37);
    write_exr_verified(folder / "a.exr", picture);
    const std::string in = "oiiotool '" + (folder / "a.exr") + "' ";
    const std::string out = " -o '" + (folder / "b.exr") + "'";
    ASSERT_EQ(run_program(in + "--tile 16 16" + out), 0);
    EXPECT_EQ(read_exr(folder / "b.exr").find("Z")->values, picture.find("Z")->values);
    // The window moves off the display's corner; the pixels stay.
    ASSERT_EQ(run_program(in + "--origin -7+5" + out), 0);
    EXPECT_EQ(read_exr(folder / "b.exr").find("Z")->values, picture.find("Z")->values);
    for (const char* compression : {"none", "rle", "zips"}) {
        ASSERT_EQ(run_program(in + "--compression " + compression + out), 0);
        EXPECT_EQ(read_exr(folder / "b.exr").find("Z")->values, picture.find("Z")->values) << compression;
    }
}

}  // namespace
}  // namespace dapple::image
