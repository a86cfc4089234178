#include "render/segment_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dapple {
namespace {

/// A piece a pixel: parallel segments along -z from a plane, a centimetre apart, with the length of a
/// function of the pixel.
template <typename Length>
view::SegmentLayer parallel_segments(int width, int height, const Length& length) {
    view::SegmentLayer layer;
    layer.width = width;
    layer.height = height;
    layer.first.push_back(0);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            layer.origin.emplace_back(0.01f * static_cast<float>(x), -0.01f * static_cast<float>(y), 0);
            layer.direction.emplace_back(0, 0, -1);
            layer.length.push_back(static_cast<float>(length(x, y)));
            layer.in_water.push_back(1);
            layer.primary.push_back(1);
            layer.throughput.emplace_back(1.0f);
            for (auto* spread : {&layer.spread_u_origin, &layer.spread_u_direction, &layer.spread_v_origin,
                                 &layer.spread_v_direction})
                spread->emplace_back(0.0f);
            layer.first.push_back(layer.first.back() + 1);
        }
    }
    return layer;
}

/// A scattering slab without extinction under even light: radiance is the length.
render::SegmentRadiance lengths_of(const view::SegmentLayer& layer) {
    render::SegmentRadiance radiance;
    for (std::size_t i = 0; i < layer.segments(); ++i) {
        radiance.direct.emplace_back(layer.length[i]);
        radiance.caustics.emplace_back(layer.length[i] + 2 * layer.origin[i].x);
    }
    return radiance;
}

std::size_t count_of(const std::vector<std::uint8_t>& asked) {
    return static_cast<std::size_t>(std::count(asked.begin(), asked.end(), 1));
}

TEST(HalfResolution, ASmoothSlabIsExactFromAQuarterOfThePixels) {
    // Odd sizes, so that the lattice reaches the last row and column.
    const view::SegmentLayer layer =
        parallel_segments(61, 33, [](int x, int y) { return 2 + 0.004 * x + 0.003 * y; });
    EXPECT_EQ(count_of(render::half_resolution_pixels(layer)), 31u * 17u);
    std::size_t asked = 0;
    const render::SegmentRadiance found =
        render::at_half_resolution(layer, [&](const view::SegmentLayer& part) {
            asked += part.segments();
            EXPECT_EQ(part.first.size(), layer.first.size());
            return lengths_of(part);
        });
    EXPECT_EQ(asked, 31u * 17u);
    const render::SegmentRadiance all = lengths_of(layer);
    for (std::size_t i = 0; i < layer.segments(); ++i) {  // linear: equal to round-off of floats
        EXPECT_NEAR(found.direct[i].x, all.direct[i].x, 1e-6);
        EXPECT_NEAR(found.caustics[i].y, all.caustics[i].y, 1e-6);
    }
}

TEST(HalfResolution, TheLastColumnAndRowOfAnEvenPictureAreAskedForThemselves) {
    const view::SegmentLayer layer = parallel_segments(8, 6, [](int, int) { return 2.0; });
    const std::vector<std::uint8_t> asked = render::half_resolution_pixels(layer);
    for (std::size_t y = 0; y < 6; ++y) {
        for (std::size_t x = 0; x < 8; ++x)
            EXPECT_EQ(asked[y * 8 + x], (x % 2 == 0 && y % 2 == 0) || x == 7 || y == 5 ? 1 : 0);
    }
}

TEST(HalfResolution, EdgesOfAColumnStaySharp) {
    // A column 40 cm before a wall at 2 m, its edges within lattice cells both ways.
    const auto length = [](int x, int y) { return x >= 13 && x < 22 && y >= 6 ? 1.6 : 2.0; };
    const view::SegmentLayer layer = parallel_segments(41, 25, length);
    const render::SegmentRadiance found = render::at_half_resolution(layer, lengths_of);
    for (std::size_t i = 0; i < layer.segments(); ++i)
        EXPECT_NEAR(found.direct[i].x, layer.length[i], 1e-6) << i % 41 << " " << i / 41;
    // A ring of pixels at most: two edges of 19 pixels and one of 9, each one lattice cell wide.
    const std::size_t lattice = 21 * 13;
    EXPECT_LE(count_of(render::half_resolution_pixels(layer)), lattice + 2 * (2 * 19 + 9));
}

TEST(HalfResolution, SegmentsThatDoNotMatchAreAskedForThemselves) {
    const view::SegmentLayer level = parallel_segments(5, 5, [](int, int) { return 2.0; });
    const auto asked_with = [&](auto&& change) {
        view::SegmentLayer changed = level;
        change(changed);
        return render::half_resolution_pixels(changed);
    };
    const std::size_t pixel = 2 * 5 + 2;  // of the lattice
    // All eight pixels about it hang on it.
    const auto expect_ring = [&](const std::vector<std::uint8_t>& asked) {
        EXPECT_EQ(count_of(asked), 9u + 8u);
        for (const std::size_t i : {6u, 7u, 8u, 11u, 13u, 16u, 17u, 18u}) EXPECT_EQ(asked[i], 1);
    };
    EXPECT_EQ(count_of(render::half_resolution_pixels(level)), 9u);
    expect_ring(asked_with([&](view::SegmentLayer& layer) { layer.in_water[pixel] = 0; }));
    expect_ring(asked_with([&](view::SegmentLayer& layer) { layer.length[pixel] = 2.2f; }));
    expect_ring(asked_with([&](view::SegmentLayer& layer) { layer.origin[pixel].z = 0.2f; }));
    expect_ring(asked_with(
        [&](view::SegmentLayer& layer) { layer.direction[pixel] = glm::normalize(glm::vec3(0.1f, 0, -1)); }));
    // Within a hundredth of the length: between the others.
    EXPECT_EQ(count_of(asked_with([&](view::SegmentLayer& layer) { layer.length[pixel] = 2.03f; })), 9u);
    // A pixel without a segment among others that have one.
    const auto without = [&](std::size_t gone) {
        std::vector<std::uint8_t> kept(25, 1);
        kept[gone] = 0;
        return render::half_resolution_pixels(render::segments_of(level, kept));
    };
    expect_ring(without(pixel));
    EXPECT_EQ(without(pixel + 1)[pixel + 1], 1);
}

}  // namespace
}  // namespace dapple
