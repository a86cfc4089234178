#include "image/texture.h"

#include <gmock/gmock.h>

#include <fstream>
#include <limits>

#include "base/error.h"
#include "base/hash.h"
#include "image/exr.h"
#include "image/png.h"
#include "image/temporary_folder.h"
#include "source_dir.h"

namespace dapple::image {
namespace {

using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::vector<float> random_rgb(int width, int height) {
    std::vector<float> rgb(3 * static_cast<std::size_t>(width * height));
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<float>(hash_uniform(4, 0, i, 0));
    return rgb;
}

glm::dvec3 mean_of(const std::vector<float>& rgb) {
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < rgb.size(); i += 3) sum += glm::dvec3(rgb[i], rgb[i + 1], rgb[i + 2]);
    return sum / (static_cast<double>(rgb.size()) / 3);
}

void leave_alone(std::span<float>) {}

std::string failure_of_loading(const std::string& path) {
    try {
        Texture::load(path, leave_alone);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        return error.what();
    }
    ADD_FAILURE() << path << " was loaded";
    return {};
}

TEST(Texture, IsExactAtTexelCentres) {
    const int width = 16;
    const int height = 8;
    const auto rgb = random_rgb(width, height);
    const Texture texture(width, height, rgb);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            // Row 0 is the top, where v is 1. Centres of powers of two are exact in float.
            const glm::vec2 uv((static_cast<float>(x) + 0.5f) / width,
                               1 - (static_cast<float>(y) + 0.5f) / height);
            const glm::vec3 value = texture.sample(uv, 0);
            for (int c = 0; c < 3; ++c) {
                EXPECT_EQ(value[c], rgb[static_cast<std::size_t>(3 * (y * width + x) + c)]) << x << " " << y;
            }
            EXPECT_EQ(texture.sample(uv, 1.0f / width), value);
            EXPECT_EQ(texture.sample(uv + glm::vec2(5, -3), 0), value);
        }
    }
}

TEST(Texture, CornersAreWhereTheyBelong) {
    const Texture texture(2, 2, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1});  // red green / blue white
    EXPECT_EQ(texture.sample({0.25f, 0.25f}, 0), glm::vec3(0, 0, 1));
    EXPECT_EQ(texture.sample({0.75f, 0.25f}, 0), glm::vec3(1, 1, 1));
    EXPECT_EQ(texture.sample({0.25f, 0.75f}, 0), glm::vec3(1, 0, 0));
    EXPECT_EQ(texture.sample({0.75f, 0.75f}, 0), glm::vec3(0, 1, 0));
}

TEST(Texture, IsLinearBetweenCentresAndAcrossTheSeam) {
    const Texture texture(4, 1, {0, 0, 0, 1, 1, 1, 2, 2, 2, 7, 7, 7});
    EXPECT_FLOAT_EQ(texture.sample({0.25f, 0.5f}, 0).x, 0.5f);
    EXPECT_FLOAT_EQ(texture.sample({0.25f + 0.0625f, 0.5f}, 0).x, 0.75f);
    EXPECT_FLOAT_EQ(texture.sample({0.0f, 0.5f}, 0).x, 3.5f);  // half of the first, half of the last
    EXPECT_FLOAT_EQ(texture.sample({1.0f, 0.5f}, 0).x, 3.5f);
    EXPECT_FLOAT_EQ(texture.sample({-1e-9f, 0.5f}, 0).x, 3.5f);
    EXPECT_FLOAT_EQ(texture.sample({-1.0f / 16, 0.5f}, 0).x, 7 * 0.75f);
}

TEST(Texture, PyramidKeepsTheMean) {
    for (const auto& [width, height] : {std::pair{64, 64}, {37, 5}, {1, 9}, {100, 3}, {1, 1}}) {
        const auto rgb = random_rgb(width, height);
        const Texture texture(width, height, rgb);
        const glm::dvec3 mean = mean_of(rgb);
        const glm::vec3 coarsest = texture.sample({0.3f, 0.9f}, 1e6f);
        // At most 7 levels, each rounding a sum of at most 9 products: far below 1e-5.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(coarsest[c], mean[c], 1e-5) << width << " x " << height;
    }
}

TEST(Texture, LevelsAreBoxesOfTexels) {
    const Texture texture(4, 4, [] {
        std::vector<float> rgb(48, 0.0f);
        rgb[0] = 4;  // one red texel, top left
        return rgb;
    }());
    ASSERT_EQ(texture.level_count(), 3);
    // A footprint of two texels is level 1; the centre of its top left texel.
    EXPECT_FLOAT_EQ(texture.sample({0.25f, 0.75f}, 0.5f).x, 1.0f);
    EXPECT_FLOAT_EQ(texture.sample({0.25f, 0.75f}, 1.0f).x, 0.25f);
    // Half-way between both levels: a footprint of 2 sqrt(2) texels.
    EXPECT_NEAR(texture.sample({0.25f, 0.75f}, 0.70710678f).x, 0.625f, 1e-6f);
}

TEST(Texture, AFootprintThatIsNoNumberIsSharp) {
    const Texture texture(2, 1, {0, 0, 0, 1, 1, 1});
    EXPECT_EQ(texture.sample({0.75f, 0.5f}, std::numeric_limits<float>::quiet_NaN()).x, 1);
    EXPECT_EQ(texture.sample({0.75f, 0.5f}, std::numeric_limits<float>::infinity()).x, 0.5f);
}

TEST(Texture, OnceItsOutermostTexelsGoOn) {
    const Texture texture(4, 2, random_rgb(4, 2));
    const float middle = 0.75f;  // of the upper row
    // Left of the middle of the first texel nothing of the last is mixed in, as where it repeats.
    const glm::vec3 first = texture.sample({0.125f, middle}, 0);
    for (const float u : {0.125f, 0.05f, 0.0f, -3.0f}) EXPECT_EQ(texture.sample_once({u, middle}, 0), first);
    EXPECT_NE(texture.sample({0.05f, middle}, 0), first);
    EXPECT_EQ(texture.sample_once({0.125f, 7}, 0), first);
    // Within, and of wide footprints, the two are one.
    EXPECT_EQ(texture.sample_once({0.4f, 0.6f}, 0), texture.sample({0.4f, 0.6f}, 0));
    EXPECT_EQ(texture.sample_once({0.4f, 0.6f}, 1), texture.sample({0.4f, 0.6f}, 1));
    EXPECT_EQ(texture.rgb().size(), 24U);
    EXPECT_EQ(texture.rgb()[0], first.r);
}

TEST(Texture, FilesAreToldApartByContent) {
    const TemporaryFolder folder;
    Image picture;
    picture.width = 2;
    picture.height = 1;
    for (const char* name : {"R", "G", "B"}) picture.add(name).values = {0.25f, 3.0f};
    write_exr_verified(folder / "exr.png", picture);
    const std::vector<std::uint8_t> codes{51, 51, 51, 255, 255, 255};
    write_png(folder / "png.exr", 2, 1, codes);
    const auto doubled = [](std::span<float> rgb) {
        for (float& value : rgb) value *= 2;
    };
    EXPECT_EQ(Texture::load(folder / "exr.png", doubled).sample({0.75f, 0.5f}, 0),
              glm::vec3(3));  // linear already
    EXPECT_EQ(Texture::load(folder / "png.exr", doubled).sample({0.75f, 0.5f}, 0), glm::vec3(2));
    EXPECT_FLOAT_EQ(Texture::load(folder / "png.exr", doubled).sample({0.25f, 0.5f}, 0).x, 0.4f);
}

TEST(Texture, GreyExrServesAllChannels) {
    const TemporaryFolder folder;
    Image picture;
    picture.width = 1;
    picture.height = 1;
    picture.add("Y").values = {0.3f};
    write_exr_verified(folder / "a.exr", picture);
    EXPECT_EQ(Texture::load(folder / "a.exr", leave_alone).sample({0, 0}, 0), glm::vec3(0.3f));
}

TEST(Texture, BadFilesAreNamed) {
    const TemporaryFolder folder;
    EXPECT_THAT(failure_of_loading(folder / "none.png"), StartsWith(folder / "none.png"));
    std::ofstream(folder / "a.png") << "no picture";
    EXPECT_THAT(failure_of_loading(folder / "a.png"),
                AllOf(StartsWith(folder / "a.png"), HasSubstr("EXR or a PNG")));
    std::ofstream(folder / "b.png") << "\x89PNG\r\n\x1a\nbroken";
    EXPECT_THAT(failure_of_loading(folder / "b.png"),
                AllOf(StartsWith(folder / "b.png"), HasSubstr("no readable PNG")));
    Image picture;
    picture.width = 1;
    picture.height = 1;
    picture.add("Z");
    write_exr_verified(folder / "c.exr", picture);
    EXPECT_THAT(failure_of_loading(folder / "c.exr"),
                AllOf(StartsWith(folder / "c.exr"), HasSubstr("R, G and B")));
}

TEST(Texture, ShippedAssetsLoad) {
    for (const char* name : {"pool_tile", "sand", "concrete"}) {
        const Texture texture =
            Texture::load(std::string(DAPPLE_SOURCE_DIR "/sequences/assets/") + name + ".png", leave_alone);
        EXPECT_EQ(texture.width(), 512);
        EXPECT_EQ(texture.height(), 512);
    }
}

}  // namespace
}  // namespace dapple::image
