#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>
#include <numeric>
#include <stdexcept>

#include "base/error.h"
#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "spirv/test_texel_copy_comp.h"
#include "spirv/test_volume_sample_comp.h"

namespace dapple::gpu {
namespace {

constexpr int kWidth = 37;  // odd, so that padded rows would show
constexpr int kHeight = 11;
constexpr std::size_t kPixels = kWidth * kHeight;

struct FormatCase {
    const char* name;
    Format format;
    std::size_t channels;
};

class Copy : public ::testing::TestWithParam<FormatCase> {};

TEST_P(Copy, ThereAndBackKeepsEveryValue) {
    Device& device = test::validated_device();
    const Image image(device, "image", kWidth, kHeight, GetParam().format);
    Buffer from(device, "from", kPixels * GetParam().channels * sizeof(float));
    Buffer to(device, "to", from.bytes());
    // Depth lies in 0..1; the other formats would take anything.
    for (std::size_t i = 0; i < from.as<float>().size(); ++i)
        from.as<float>()[i] = static_cast<float>(i) / 4096;
    PassList passes(device);
    FrameStats stats;
    passes.copy("up", from, image);
    passes.copy("down", image, to);
    passes.run(stats);
    for (std::size_t i = 0; i < from.as<float>().size(); ++i)
        ASSERT_EQ(to.as<float>()[i], from.as<float>()[i]) << i;
}

INSTANTIATE_TEST_SUITE_P(Formats, Copy,
                         ::testing::Values(FormatCase{"rgba32f", Format::rgba32f, 4},
                                           FormatCase{"rg32f", Format::rg32f, 2},
                                           FormatCase{"r32f", Format::r32f, 1},
                                           FormatCase{"r32u", Format::r32u, 1},
                                           FormatCase{"depth32f", Format::depth32f, 1}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Volumes, AreFilteredBetweenTexelsAndEvenBeyondTheirFaces) {
    Device& device = test::validated_device();
    const glm::ivec3 size(5, 4, 3);
    const Image volume(device, "volume", {size.x, size.y, size.z});
    EXPECT_EQ(volume.depth(), 3);
    const auto value = [](glm::vec3 texel) { return texel.x + 8 * texel.y + 64 * texel.z; };
    Buffer from(device, "from", 5 * 4 * 3 * sizeof(std::uint16_t));
    std::size_t next = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                from.as<std::uint16_t>()[next++] = glm::packHalf1x16(value({x, y, z}));
    // Texels' centres are at + 0.5.
    const std::vector<glm::vec3> points = {{0.5, 0.5, 0.5}, {4.5, 3.5, 2.5}, {2.25, 1.75, 1},
                                           {3.1, 0.6, 2.4}, {-1, 2.5, 1.5},  {9, 9, 9}};
    Buffer at(device, "points", points.size() * sizeof(glm::vec3)),
        to(device, "to", points.size() * sizeof(float));
    std::copy(points.begin(), points.end(), at.as<glm::vec3>().begin());
    const ComputePipeline sample(device, "sample", test_volume_sample_comp,
                                 {.storage_buffers = 2, .sampled_images = 1});
    PassList passes(device);
    FrameStats stats;
    passes.copy("up", from, volume);
    passes.compute("sample", sample, {.buffers = {&at, &to}, .images = {&volume}, .writes = {&to}},
                   {1, 1, 1});
    passes.run(stats);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::vec3 texel = glm::clamp(points[i] - 0.5f, glm::vec3(0), glm::vec3(size - 1));
        // Devices may round weights to 8 bits.
        EXPECT_NEAR(to.as<float>()[i], value(texel), 73.0 / 512) << i;
    }
    EXPECT_THROW(Image(device, "flat", {4, 4, 0}), Error);
    EXPECT_THROW(Image(device, "long", {device.largest_volume() + 1, 1, 1}), Error);
}

TEST(Images, ShadersFetchTexelsInRowsFromTheTop) {
    Device& device = test::validated_device();
    const Image image(device, "image", kWidth, kHeight, Format::rgba32f);
    Buffer from(device, "from", kPixels * sizeof(glm::vec4));
    Buffer to(device, "to", from.bytes());
    std::iota(from.as<float>().begin(), from.as<float>().end(), -7.25f);
    const ComputePipeline fetch(device, "fetch", test_texel_copy_comp,
                                {.storage_buffers = 1, .sampled_images = 1});
    PassList passes(device);
    FrameStats stats;
    passes.copy("up", from, image);
    passes.compute("fetch", fetch, {.buffers = {&to}, .images = {&image}, .writes = {&to}},
                   {(kWidth + 7) / 8, (kHeight + 7) / 8, 1});
    passes.run(stats);
    for (std::size_t i = 0; i < kPixels * 4; ++i) ASSERT_EQ(to.as<float>()[i], from.as<float>()[i]) << i;
}

TEST(Images, ARectangleIsCopiedTightly) {
    Device& device = test::validated_device();
    const Image image(device, "image", kWidth, kHeight, Format::rgba32f);
    Buffer from(device, "from", kPixels * sizeof(glm::vec4));
    std::iota(from.as<float>().begin(), from.as<float>().end(), -7.25f);
    constexpr Texels kPart{2, 1, kWidth - 5, kHeight - 2};
    Buffer to(device, "to", static_cast<std::size_t>(kPart.columns * kPart.rows) * sizeof(glm::vec4));
    PassList passes(device);
    FrameStats stats;
    passes.copy("up", from, image);
    passes.copy("part", image, kPart, to);
    passes.run(stats);
    for (int row = 0; row < kPart.rows; ++row)
        for (int column = 0; column < kPart.columns; ++column)
            ASSERT_EQ(to.as<glm::vec4>()[static_cast<std::size_t>(row * kPart.columns + column)],
                      from.as<glm::vec4>()[static_cast<std::size_t>((kPart.top + row) * kWidth + kPart.left +
                                                                    column)]);
    for (const Texels& outside : {Texels{-1, 0, 4, 4}, Texels{0, 2, 4, kHeight - 1}, Texels{0, 0, 0, 4}})
        EXPECT_THROW(passes.copy("part", image, outside, to), std::logic_error);
}

TEST(Images, SmallBuffersAndAbsurdSizesAreRefused) {
    Device& device = test::validated_device();
    const Image image(device, "image", kWidth, kHeight, Format::rgba32f);
    const Buffer small(device, "small", kPixels * sizeof(glm::vec4) - 1);
    PassList passes(device);
    EXPECT_THROW(passes.copy("down", image, small), std::logic_error);
    EXPECT_THROW(passes.copy("up", small, image), std::logic_error);
    for (const int width : {0, -1, 1'000'000}) {
        try {
            const Image absurd(device, "absurd", width, 8, Format::r32f);
            FAIL() << width;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::device);
            EXPECT_NE(std::string(error.what()).find("'absurd'"), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace dapple::gpu
