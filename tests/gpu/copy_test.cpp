#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <numeric>
#include <stdexcept>

#include "base/error.h"
#include "gpu/pass_list.h"
#include "gpu/validated_device.h"
#include "spirv/test_texel_copy_comp.h"

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
