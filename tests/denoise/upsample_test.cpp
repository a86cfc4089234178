// Irradiance at every second or fourth pixel brought to all.
#include <gtest/gtest.h>

#include <cmath>

#include "denoise/layers.h"
#include "denoise/upsample.h"

namespace dapple {
namespace {

using denoise::CoarseGrid;
using denoise::Irradiance;

/// Receivers of a coarse picture over plane_layer(width, height, spacing): the middles of its pixels, the
/// margin being the same on all sides.
view::ReceiverLayer coarse_plane(int width, int height, float spacing, const CoarseGrid& grid) {
    const auto scale = static_cast<float>(grid.scale);
    view::ReceiverLayer layer = test::plane_layer(width, height, scale * spacing);
    const glm::vec2 first = spacing * (0.5f * (scale - 1) - glm::vec2(grid.margin));
    for (glm::vec3& position : layer.position) position += glm::vec3(first.x, 0, first.y);
    return layer;
}

Irradiance covered(std::vector<glm::vec3> values) {
    const std::size_t count = values.size();
    return {std::move(values), std::vector<std::uint8_t>(count, 1)};
}

CoarseGrid grid_of(int scale, double margin) {
    CoarseGrid grid;
    grid.scale = scale;
    grid.margin = glm::dvec2(margin);
    return grid;
}

/// Bilinear weights sum to one and reproduce linear functions; at the picture's border the nearest values go
/// on.
TEST(Upsample, LinearFunctionsStay) {
    for (const int scale : {2, 4}) {
        // 33 x 21 pixels in pictures of 17 x 11 and 9 x 6.
        const CoarseGrid even = grid_of(scale, 0);
        CoarseGrid grid = even;
        const glm::ivec2 size((33 + scale - 1) / scale, (21 + scale - 1) / scale);
        grid.margin = 0.5 * glm::dvec2(scale * size.x - 33, scale * size.y - 21);
        const view::ReceiverLayer fine = test::plane_layer(33, 21, 0.01f);
        const view::ReceiverLayer coarse = coarse_plane(size.x, size.y, 0.01f, grid);
        const auto linear = [](const glm::vec3& p) { return glm::vec3(1 + p.x, 2 - p.z, 3); };
        Irradiance from = covered({});
        for (const glm::vec3& position : coarse.position) from.values.push_back(linear(position));
        from.covered.assign(coarse.pixels(), 1);
        Irradiance to;
        EXPECT_TRUE(denoise::upsample(fine, coarse, from, grid, to).empty());
        for (std::size_t i = 0; i < fine.pixels(); ++i) {
            const std::size_t x = i % 33, y = i / 33;
            const auto edge = static_cast<std::size_t>(scale);
            EXPECT_EQ(to.covered[i], 1);
            EXPECT_NEAR(to.values[i].z, 3, 1e-6f);  // a mean of threes
            const bool inside = x >= edge && y >= edge && x + edge < 33 && y + edge < 21;
            // Half a coarse pixel at the border.
            const float off = inside ? 2e-6f : 0.005f * static_cast<float>(scale) + 1e-6f;
            EXPECT_NEAR(to.values[i].x, linear(fine.position[i]).x, off) << i;
            EXPECT_NEAR(to.values[i].y, linear(fine.position[i]).y, off) << i;
        }
    }
}

/// Left of x = 15 another object than right of it: no value crosses, to the bit.
TEST(Upsample, NothingCrossesEdges) {
    const CoarseGrid grid = grid_of(2, 0);
    view::ReceiverLayer fine = test::plane_layer(32, 16, 0.01f);
    view::ReceiverLayer coarse = coarse_plane(16, 8, 0.01f, grid);
    Irradiance from = covered(std::vector<glm::vec3>(coarse.pixels(), glm::vec3(1)));
    for (std::size_t i = 0; i < coarse.pixels(); ++i) {
        if (i % 16 < 8) continue;
        coarse.object[i] = 1;
        from.values[i] = glm::vec3(100);
    }
    for (std::size_t i = 0; i < fine.pixels(); ++i)
        if (i % 32 >= 15) fine.object[i] = 1;
    Irradiance to;
    EXPECT_TRUE(denoise::upsample(fine, coarse, from, grid, to).empty());
    for (std::size_t i = 0; i < fine.pixels(); ++i)
        EXPECT_EQ(to.values[i].x, i % 32 < 15 ? 1.0f : 100.0f) << i % 32;
}

TEST(Upsample, LeavesOutWhatIsNotCovered) {
    const CoarseGrid grid = grid_of(2, 0);
    const view::ReceiverLayer fine = test::plane_layer(16, 16, 0.01f);
    const view::ReceiverLayer coarse = coarse_plane(8, 8, 0.01f, grid);
    Irradiance from = covered(std::vector<glm::vec3>(coarse.pixels(), glm::vec3(1)));
    for (std::size_t i = 0; i < coarse.pixels(); ++i) {
        if (i % 8 < 4) continue;
        from.covered[i] = 0;
        from.values[i] = glm::vec3(0);
    }
    Irradiance to;
    EXPECT_TRUE(denoise::upsample(fine, coarse, from, grid, to).empty());
    for (std::size_t i = 0; i < fine.pixels(); ++i) {
        // The coarse column 3 ends at fine 7; its tent reaches to 8.
        EXPECT_EQ(to.covered[i], i % 16 <= 8 ? 1 : 0) << i % 16;
        EXPECT_EQ(to.values[i].x, i % 16 <= 8 ? 1.0f : 0.0f) << i % 16;
    }
}

/// A rail one pixel wide that the coarse picture meets in one place only.
TEST(Upsample, ThinThingsTakeTheNearest) {
    const CoarseGrid grid = grid_of(4, 0);
    view::ReceiverLayer fine = test::plane_layer(64, 8, 0.01f);
    view::ReceiverLayer coarse = coarse_plane(16, 2, 0.01f, grid);
    Irradiance from = covered(std::vector<glm::vec3>(coarse.pixels(), glm::vec3(1)));
    for (std::size_t x = 0; x < 64; ++x) fine.object[3 * 64 + x] = 7;
    coarse.object[6] = 7;
    from.values[6] = glm::vec3(5);
    Irradiance to;
    const std::vector<std::size_t> missing = denoise::upsample(fine, coarse, from, grid, to);
    for (const std::size_t pixel : missing) EXPECT_EQ(pixel / 64, 3u);
    // Of the rail's 64 pixels those whose tent holds the coarse pixel's middle, at 25.5: 22 to 29.
    EXPECT_EQ(missing.size(), 64u - 8u);
    const std::vector<std::size_t> left = denoise::take_nearest(fine, coarse, from, grid, missing, to);
    // Four coarse pixels about the rounded place reach 2 to 10: fine pixels 6 (1.125) is out, 8 (1.625) in.
    std::size_t none = 0;
    for (std::size_t x = 0; x < 64; ++x) {
        const std::size_t i = 3 * 64 + x;
        EXPECT_EQ(to.values[i].x, to.covered[i] ? 5.0f : 0.0f) << x;
        if (!to.covered[i]) ++none;
    }
    EXPECT_EQ(left.size(), none);
    EXPECT_EQ(none, 64u - 36u);
}

}  // namespace
}  // namespace dapple
