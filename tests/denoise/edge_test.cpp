// What counts as one surface, and how far a pixel's filter reaches.
#include <gtest/gtest.h>

#include <cmath>

#include "denoise/adaptive_kernel.h"
#include "denoise/guide.h"
#include "denoise/layers.h"

namespace dapple {
namespace {

using denoise::edge_stop;
using denoise::Guide;

Guide on_floor(float x, float z) {
    Guide guide;
    guide.position = {x, -2, z};
    guide.surface = 1;
    guide.narrow = 0.01f;
    guide.wide = 0.02f;
    guide.rounding = 2e-6f;
    return guide;
}

/// Both are symmetric in form; floats commute in sums and products.
float both_ways(const Guide& a, const Guide& b, float pixels) {
    EXPECT_EQ(edge_stop(a, b, pixels), edge_stop(b, a, pixels));
    return edge_stop(a, b, pixels);
}

TEST(EdgeStop, IsOneOnAPlane) {
    EXPECT_EQ(both_ways(on_floor(0, 0), on_floor(0.05f, 0), 5), 1);
    Guide a = on_floor(0, 0), b = on_floor(0.03f, 0.04f);
    // A slope of 3 in 4; floats of the height leave 1e-7 m beside a slack of 4e-6.
    a.normal = b.normal = glm::normalize(glm::vec3(3, 4, 0));
    b.position.y = -2 - 0.75f * 0.03f;
    EXPECT_EQ(both_ways(a, b, 5), 1);
}

TEST(EdgeStop, IsExactlyZeroAcrossEdges) {
    const Guide a = on_floor(0, 0);
    const auto changed = [](const auto& change) {
        Guide guide = on_floor(0.05f, 0);
        change(guide);
        return guide;
    };
    EXPECT_EQ(both_ways(a, changed([](Guide& g) { g.surface = 2; }), 5), 0);
    EXPECT_EQ(both_ways(a, changed([](Guide& g) { g.surface = denoise::kNoSurface; }), 5), 0);
    // cos 26 deg = 0.899 < 0.9; a tenth of a pixel a pixel is 0.1 * 5 * 1 cm = 5 mm; the way 4 * 5 * 2 cm.
    const float lean = glm::radians(26.0f);
    EXPECT_EQ(both_ways(a, changed([&](Guide& g) { g.normal = {0, std::cos(lean), std::sin(lean)}; }), 5), 0);
    EXPECT_EQ(both_ways(a, changed([](Guide& g) { g.position.y += 0.0051f; }), 5), 0);
    EXPECT_EQ(both_ways(a, changed([](Guide& g) { g.position.x = 0.401f; }), 5), 0);
}

TEST(EdgeStop, FallsSmoothlyToZero) {
    const Guide a = on_floor(0, 0);
    Guide b = on_floor(0.05f, 0);
    b.position.y += 0.0025f;  // half of the 5 mm allowed: 1 - 1/4; 1e-3 for the slack of rounding
    EXPECT_NEAR(both_ways(a, b, 5), 0.75f, 2e-3f);
    b = on_floor(0, 0.05f);
    b.normal = {std::sqrt(1 - 0.95f * 0.95f), 0.95f, 0};  // halfway from a cosine of 1 to 0.9
    EXPECT_NEAR(both_ways(a, b, 5), 0.5f, 1e-5f);
}

TEST(EdgeStop, KnowsObjectsAndMediaApart) {
    view::ReceiverLayer layer = test::plane_layer(5, 1, 0.01f);
    layer.object[1] = 1;
    layer.flags[2] = view::kReceiver;
    layer.flags[3] |= view::kBehindSpecular;
    layer.flags[4] = 0;
    EXPECT_EQ(denoise::guide_of(layer, 4).surface, denoise::kNoSurface);
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < a; ++b)
            EXPECT_NE(denoise::guide_of(layer, a).surface, denoise::guide_of(layer, b).surface);
}

/// Equations 26 to 28 for a weakest light of luminance 3 and 0.114: C_scene = 0.342, a tenth 0.0342, a half
/// 0.171.
TEST(AdaptiveKernel, FollowsLuminance) {
    const auto is = [](float luminance, int radius, int step, float scale) {
        const denoise::Kernel kernel =
            denoise::kAdaptiveKernels[denoise::adaptive_level(luminance, 0.114f * 3)];
        EXPECT_EQ(kernel.radius, radius) << luminance;
        EXPECT_EQ(kernel.step, step) << luminance;
        EXPECT_EQ(kernel.distance_scale, scale) << luminance;
    };
    is(0, 15, 5, 15);
    is(0.0341f, 15, 5, 15);
    is(0.0343f, 10, 1, 2);
    is(0.1709f, 10, 1, 2);
    is(0.1711f, 5, 1, 1);
    is(40, 5, 1, 1);
}

TEST(AdaptiveKernel, LuminanceOfGreyIsItself) {
    EXPECT_FLOAT_EQ(denoise::luminance(glm::vec3(0.3f)), 0.3f);
    EXPECT_FLOAT_EQ(denoise::luminance({0, 1, 0}), 0.7152f);
}

}  // namespace
}  // namespace dapple
