#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "view/view_scene.h"

namespace dapple::view {
namespace {

using test::ViewScene;

/// Relative errors of the footprints against the differences of the positions that neighbouring pixels
/// reached. Pixels whose neighbours took another way are left out.
std::vector<double> footprint_errors(const ReceiverLayer& layer) {
    std::vector<double> errors;
    const auto width = static_cast<std::size_t>(layer.width);
    for (std::size_t y = 1; y + 1 < static_cast<std::size_t>(layer.height); ++y) {
        for (std::size_t x = 1; x + 1 < width; ++x) {
            const std::size_t i = y * width + x;
            bool alike = (layer.flags[i] & kReceiver) != 0 && (layer.flags[i] & kFootprintCapped) == 0;
            for (const std::size_t j : {i - 1, i + 1, i - width, i + width}) {
                alike = alike && layer.flags[j] == layer.flags[i] && layer.object[j] == layer.object[i];
            }
            if (!alike) continue;
            const glm::dvec3 u =
                0.5 * (glm::dvec3(layer.position[i + 1]) - glm::dvec3(layer.position[i - 1]));
            const glm::dvec3 v =
                0.5 * (glm::dvec3(layer.position[i + width]) - glm::dvec3(layer.position[i - width]));
            const glm::dvec3 fu(layer.footprint_u[i]);
            const glm::dvec3 fv(layer.footprint_v[i]);
            const double size = std::max(length(u), length(v));
            errors.push_back(std::max(length(u - fu), length(v - fv)) / size);
        }
    }
    std::sort(errors.begin(), errors.end());
    return errors;
}

double quantile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

/// The views below have pixels of about 1e-3 rad, so that a difference over two pixels deviates from the
/// derivative by some 1e-6 times the change of its curvature, and float positions add 2^-24 * 4 m over 2 mm:
/// 1e-4.
constexpr double kDifference = 1e-3;

ViewScene narrow(const glm::dvec3& from, const glm::dvec3& at) {
    ViewScene scene(64, 64);
    scene.look(from, at, 0.064);
    return scene;
}

TEST(Footprint, OfATiltedPlane) {
    for (const bool parallel : {false, true}) {
        ViewScene scene = narrow({1, 2, 3}, {0, 0, 0});
        if (parallel) scene.look_in_parallel({1, 2, 3}, {0, 0, 0}, 0.2);
        scene.add_floor(0).transform.rotation = {0.3, 0.2, 0.1};
        const auto errors = footprint_errors(scene.trace());
        ASSERT_EQ(errors.size(), 62u * 62u);
        EXPECT_LT(errors.back(), kDifference);
    }
}

TEST(Footprint, ThroughFlatWaterFromAboveAndBelow) {
    ViewScene above = narrow({1, 1, 2}, {0, 0, 0});
    above.fill_flat(10);
    above.add_floor(-1);
    const auto from_above = footprint_errors(above.trace());
    ASSERT_EQ(from_above.size(), 62u * 62u);
    EXPECT_LT(from_above.back(), kDifference);

    ViewScene below = narrow({0.3, -2, 0.2}, {0, 0, 0});
    below.fill_flat(10);
    below.add_floor(2);
    const auto from_below = footprint_errors(below.trace());
    ASSERT_EQ(from_below.size(), 62u * 62u);
    EXPECT_LT(from_below.back(), kDifference);
}

TEST(Footprint, OnASphereAndAnEllipsoid) {
    for (const double stretch : {1.0, 2.0}) {
        ViewScene scene = narrow({1, 2, 3}, {0, 0, 0});
        scene.add(scene::Shape::sphere, {0, 0, 0}).transform.scale = {1, stretch, 1};
        const auto errors = footprint_errors(scene.trace());
        ASSERT_EQ(errors.size(), 62u * 62u);
        EXPECT_LT(errors.back(), kDifference);
    }
}

TEST(Footprint, InTextureIsTheDifferenceOfTextureCoordinates) {
    for (const auto shape : {scene::Shape::plane, scene::Shape::box, scene::Shape::sphere}) {
        ViewScene scene = narrow({1, 2.5, 3}, {0.1, 0.35, 0.2});  // the sphere at a latitude of 35 degrees
        scene::Object& object = scene.add(shape, {0, 0, 0});
        object.material.texture_size = 0.3;
        object.transform.scale = {1.5, 1.5, 1.5};
        object.transform.rotation = {0.1, 0.2, 0};
        const ReceiverLayer layer = scene.trace();
        std::size_t compared = 0;
        for (std::size_t y = 1; y < 63; ++y) {
            for (std::size_t x = 1; x < 63; ++x) {
                const std::size_t i = y * 64 + x;
                const bool alike = layer.geometric_normal[i - 65] == layer.geometric_normal[i + 65] ||
                                   shape == scene::Shape::sphere;
                if (!alike || layer.flags[i - 65] != kReceiver || layer.flags[i + 65] != kReceiver) continue;
                const glm::vec2 along_u = 0.5f * (layer.uv[i + 1] - layer.uv[i - 1]);
                const glm::vec2 along_v = 0.5f * (layer.uv[i + 64] - layer.uv[i - 64]);
                const double width = std::max(length(along_u), length(along_v));
                EXPECT_NEAR(layer.uv_width[i], width, 2 * kDifference * width);
                ++compared;
            }
        }
        EXPECT_GT(compared, 2000u);
    }
}

TEST(Footprint, ByACurvedMirror) {
    for (const double stretch : {1.0, 2.0}) {
        ViewScene scene = narrow({1, 2, 3}, {0, 0, 0});
        scene::Object& ball = scene.add(scene::Shape::sphere, {0, 0, 0});
        ball.material.mirror = true;
        ball.transform.scale = {1, stretch, 1};
        scene.add(scene::Shape::sphere, {0, 0, 0}).radius = 10;  // seen from inside
        const auto errors = footprint_errors(scene.trace());
        ASSERT_EQ(errors.size(), 62u * 62u);
        EXPECT_LT(errors.back(), 3 * kDifference);  // the mirror's curvature widens pixels tenfold
    }
}

TEST(Footprint, ThroughGlass) {
    for (const auto shape : {scene::Shape::box, scene::Shape::sphere}) {
        ViewScene scene = narrow({1, 2, 3}, {0.1, 0.1, 0});
        scene::Object& body = scene.add(shape, {0, 0, 0});
        body.material.glass = true;
        body.transform.rotation = {0.3, 0.2, 0.1};
        scene.fill_flat(10);  // half of the body is in the water
        scene.add_floor(-1.5);
        const auto errors = footprint_errors(scene.trace());
        // Neighbours part at edges of the box and where they leave it above and below the water.
        EXPECT_GT(errors.size(), 2500u);
        // A ball of index 1.5 focuses near itself: the footprint changes by more within a pixel.
        EXPECT_LT(quantile(errors, 0.99), kDifference);
    }
}

TEST(Footprint, ThroughWavyWater) {
    ViewScene scene = narrow({0.3, 1, 0.5}, {0, 0, 0});
    scene.fill(test::wavy_water(4, 1600), 4);
    scene.add_floor(-1);
    const auto errors = footprint_errors(scene.trace());
    ASSERT_EQ(errors.size(), 62u * 62u);
    // Cells are as wide as two pixels (2.5 mm). The derivative of the interpolated normal is constant in a
    // triangle and differs from the next one's by about (wave number) * (cell) = 1 %, which refraction passes
    // on by a quarter of the depth; differences between pixels see a mean of a few triangles. Without the
    // curvature of the water the median alone would be 10 %.
    EXPECT_LT(quantile(errors, 0.5), 3e-3);
    EXPECT_LT(errors.back(), 0.02);
}

TEST(Footprint, IsCutWhereTheViewGrazes) {
    ViewScene scene(8, 64);
    scene.look({0, 0.5, 0}, {0, 0.5, -10}, 0.02);
    scene.add_floor(0, 1e5);
    const ReceiverLayer layer = scene.trace();
    std::size_t capped = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        if (!(layer.flags[i] & kReceiver)) continue;
        const double distance = length(layer.position[i] - glm::vec3(0, 0.5f, 0));
        const double width = 0.02 / 64 * distance;
        const double length_v = length(layer.footprint_v[i]);
        // On the floor a pixel's beam is stretched by 1 / cos = distance / height.
        const double expected = width * std::min(64.0, distance / 0.5);
        EXPECT_NEAR(length_v, expected, 0.02 * expected);
        EXPECT_EQ((layer.flags[i] & kFootprintCapped) != 0, distance / 0.5 > 64);
        capped += (layer.flags[i] & kFootprintCapped) != 0 ? 1 : 0;
    }
    EXPECT_GT(capped, 100u);
}

TEST(Footprint, IsFiniteAtTheCriticalAngle) {
    // A picture across the edge of Snell's window, towards a far ceiling.
    ViewScene scene(256, 256);
    const double critical = std::asin(1 / 1.333);
    scene.look({0, -1, 0}, {std::tan(critical), 0, 0}, 1e-4);
    scene.fill_flat(100);
    scene.add_floor(50, 1e6);
    scene.add_floor(-50, 1e6);
    for (const int branch : {0, 1}) {
        const ReceiverLayer layer = scene.trace(branch);
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            const glm::vec3 sum =
                layer.footprint_u[i] + layer.footprint_v[i] + layer.position[i] + layer.throughput[i];
            ASSERT_TRUE(std::isfinite(sum.x + sum.y + sum.z + layer.uv_width[i]));
        }
    }
}

}  // namespace
}  // namespace dapple::view
