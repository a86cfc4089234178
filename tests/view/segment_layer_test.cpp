#include "view/segment_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/parallel.h"
#include "view/camera.h"
#include "view/segment_recorder.h"
#include "view/view_scene.h"

namespace dapple::view {
namespace {

/// Of a pixel, by its place in rows of `width`.
glm::dvec2 middle_of(std::size_t pixel, std::size_t width) {
    const std::size_t row = pixel / width;
    return {static_cast<double>(pixel % width) + 0.5, static_cast<double>(row) + 0.5};
}

using test::ViewScene;

constexpr double kIndex = 1.333;
/// Throughputs and lengths are found in double and rounded to float once.
constexpr double kFloat = 1e-6;

struct Traced {
    ReceiverLayer receivers;
    SegmentLayer segments;
};
Traced trace(const ViewScene& scene, int branch = 0) {
    Traced traced;
    LayerCounts counts;
    const rays::RayScene rays(scene.frame);
    traced.receivers = trace_layer(scene.frame, rays, {0, branch}, counts, &traced.segments);
    return traced;
}

scene::Water& scatter(scene::Water& water) {
    water.absorption = {0.35, 0.06, 0.03};
    water.scattering = {0.05, 0.1, 0.2};
    return water;
}

glm::dvec3 direction_of(const ViewScene& scene, std::size_t pixel) {
    const scene::Clip& clip = scene.frame.state.clip;
    glm::dvec3 origin, direction;
    const auto width = static_cast<std::size_t>(clip.width);
    Camera(scene.frame.state.camera, clip.width, clip.height).ray(middle_of(pixel, width), origin, direction);
    return direction;
}

void expect_near(const glm::vec3& found, const glm::dvec3& expected, double share = kFloat) {
    EXPECT_LT(length(glm::dvec3(found) - expected), share * std::max(1e-3, length(expected)));
}

TEST(SegmentLayer, OnePieceFromACameraUnderWaterToTheFloor) {
    ViewScene scene(8, 6);
    scene.look({0, -1, 0}, {1, -3, 0});
    scatter(scene.fill_flat(40));
    scene.add_floor(-5);
    const Traced traced = trace(scene);
    const SegmentLayer& layer = traced.segments;
    ASSERT_EQ(layer.width, 8);
    ASSERT_EQ(layer.height, 6);
    ASSERT_EQ(layer.segments(), 48u);
    const Camera camera(scene.camera(), 8, 6);
    for (std::size_t i = 0; i < 48; ++i) {
        EXPECT_EQ(layer.first[i], i);
        const glm::dvec3 direction = direction_of(scene, i);
        expect_near(layer.origin[i], {0, -1, 0});
        expect_near(layer.direction[i], direction);
        EXPECT_NEAR(layer.length[i], -4 / direction.y, kFloat * layer.length[i]);
        EXPECT_EQ(layer.in_water[i], 1);
        EXPECT_EQ(layer.throughput[i], glm::vec3(1));
        // The spread is the footprint of a plane across the direction: no origin, and the pixel's angle.
        glm::dvec3 origin_du, origin_dv, direction_du, direction_dv;
        camera.ray_differentials(middle_of(i, 8), origin_du, origin_dv, direction_du, direction_dv);
        EXPECT_EQ(layer.spread_u_origin[i], glm::vec3(0));
        expect_near(layer.spread_u_direction[i], direction_du);
        expect_near(layer.spread_v_direction[i], direction_dv);
    }
    EXPECT_EQ(trace(scene, 1).segments.segments(), 0u) << "nothing splits";
}

TEST(SegmentLayer, NothingWhereNothingScatters) {
    ViewScene scene(4, 4);
    scene.look({0, -1, 0}, {1, -3, 0});
    scene.fill_flat(40);
    scene.add_floor(-5);
    const SegmentLayer layer = trace(scene).segments;
    EXPECT_EQ(layer.segments(), 0u);
    EXPECT_EQ(layer.first, std::vector<std::uint32_t>(17, 0));
}

TEST(SegmentLayer, FromAboveThePieceBelowCarriesFresnelAndTheIndexSquared) {
    ViewScene scene(6, 6);
    scene.look_in_parallel({-2, 3, 0}, {0, 0, 0}, 1);
    scatter(scene.fill_flat(20));
    scene.add_floor(-2);
    const SegmentLayer layer = trace(scene).segments;
    ASSERT_EQ(layer.segments(), 36u) << "the way in the air is no segment";
    const test::Crossing crossing = test::cross_surface(-direction_of(scene, 0).y, 1, kIndex);
    for (std::size_t i = 0; i < 36; ++i) {
        expect_near(layer.throughput[i], glm::dvec3(crossing.transmittance / (kIndex * kIndex)));
        EXPECT_NEAR(layer.length[i], 2 / crossing.cos_t, kFloat * layer.length[i]);
        EXPECT_NEAR(layer.origin[i].y, 0, 1e-6);
        EXPECT_EQ(layer.in_water[i], 1);
        // What the pixel sees of the floor is the piece's throughput, attenuated along it.
        const glm::dvec3 end =
            glm::dvec3(layer.throughput[i]) *
            glm::exp(-static_cast<double>(layer.length[i]) * scene.frame.state.water->extinction());
        EXPECT_GT(length(end), 0);
    }
    EXPECT_EQ(trace(scene, 1).segments.segments(), 0u) << "the reflected path stays in the air";
}

/// Looking up from under water: the piece to the surface once, then the reflected piece down to the floor in
/// the branch that it belongs to.
TEST(SegmentLayer, PiecesBeforeTheSplitBelongToTheFirstBranchOnly) {
    ViewScene scene(32, 32);
    scene.look({0.3, -2, 0.2}, {0.3, 0, 0.2}, 2.2);  // to 62 degrees: total reflection from 48.6
    const scene::Water water = scatter(scene.fill_flat(3));
    scene.add_floor(-5, 1000);
    const Traced first = trace(scene, 0), second = trace(scene, 1);
    std::size_t inside = 0;
    for (std::size_t pixel = 0; pixel < 1024; ++pixel) {
        const glm::dvec3 direction = direction_of(scene, pixel);
        const test::Crossing crossing = test::cross_surface(direction.y, kIndex, 1);
        const double up = 2 / direction.y, down = 5 / direction.y;
        const glm::dvec3 at_surface = glm::exp(-up * water.extinction());
        const std::uint32_t a = first.segments.first[pixel], a_end = first.segments.first[pixel + 1];
        const std::uint32_t b = second.segments.first[pixel], b_end = second.segments.first[pixel + 1];
        ASSERT_EQ(first.segments.throughput[a], glm::vec3(1));
        EXPECT_NEAR(first.segments.length[a], up, kFloat * up);
        const bool splits = crossing.cos_t >= 0;
        inside += splits;
        const SegmentLayer& reflected = splits ? second.segments : first.segments;
        const std::uint32_t piece = splits ? b : a + 1;
        ASSERT_EQ(a_end - a, splits ? 1u : 2u) << "the refracted ray goes on in the air";
        ASSERT_EQ(b_end - b, splits ? 1u : 0u);
        EXPECT_NEAR(reflected.length[piece], down, kFloat * down);
        EXPECT_NEAR(reflected.origin[piece].y, 0, 1e-6);
        EXPECT_NEAR(reflected.direction[piece].y, -direction.y, 1e-6);
        expect_near(reflected.throughput[piece], (1 - crossing.transmittance) * at_surface);
        // d(point)/d(pixel) of a reflected piece: its image above the water goes on as if unreflected.
        for (const double s : {0.0, 1.0}) {
            const glm::vec3 spread = reflected.spread_u_origin[piece] +
                                     static_cast<float>(s) * reflected.spread_u_direction[piece];
            const glm::vec3 straight = static_cast<float>(up + s) * first.segments.spread_u_direction[a];
            const glm::vec3 image(spread.x, -spread.y, spread.z);
            const glm::vec3 across =
                image - glm::dot(image, first.segments.direction[a]) * first.segments.direction[a];
            EXPECT_LT(length(across - straight), 1e-5f * length(straight));
        }
    }
    EXPECT_GT(inside, 100u);
    EXPECT_LT(inside, 900u);
}

TEST(SegmentLayer, EndlessPiecesEndWhereTheClearestChannelThatScattersIsBlack) {
    ViewScene scene(4, 4);
    scene.look({0, -3, 0}, {10, -8, 0});
    scene::Water& water = scatter(scene.fill_flat(10));
    SegmentLayer layer = trace(scene).segments;
    ASSERT_EQ(layer.segments(), 16u) << "paths that end black have segments too";
    EXPECT_EQ(trace(scene).receivers.flags[5], 0u);
    const double least = 24 * std::log(2.0);
    EXPECT_NEAR(layer.length[5], least / 0.16, 1e-4);  // green lets through most: 0.06 + 0.1 /m
    // A channel that nothing scatters in shows nothing, however clear it is.
    water.scattering.y = 0;
    layer = trace(scene).segments;
    EXPECT_NEAR(layer.length[5], least / 0.23, 1e-4);  // blue: 0.03 + 0.2 /m
    water.absorption = {0, 0, 0};
    EXPECT_NEAR(trace(scene).segments.length[5], least / 0.05, 1e-3);  // red

    // Also where something stands, out of sight.
    scene.add_floor(-3000, 1e5);
    EXPECT_NEAR(trace(scene).segments.length[5], least / 0.05, 1e-3);
}

TEST(SegmentLayer, PiecesEndOnMirrorsAndGoOnBehindThem) {
    ViewScene scene(5, 5);
    scene.look({-3, -2, 0}, {0, -2.5, 0}, 0.2);
    scene::Object& mirror = scene.add(scene::Shape::plane, {0, -2, 0}, {20, 1, 20});
    mirror.transform.rotation = {0, 0, M_PI / 2};
    mirror.material.mirror = true;
    const glm::dvec3 color(0.9, 0.8, 0);
    mirror.material.color = color;
    scene.add_floor(-4);  // moves the mirror in memory
    const scene::Water water = scatter(scene.fill_flat(40));
    const SegmentLayer layer = trace(scene).segments;
    ASSERT_EQ(layer.segments(), 50u);
    for (std::size_t pixel = 0; pixel < 25; ++pixel) {
        const glm::dvec3 direction = direction_of(scene, pixel);
        const std::size_t i = layer.first[pixel];
        const double to_mirror = 3 / direction.x;
        EXPECT_NEAR(layer.length[i], to_mirror, kFloat * to_mirror);
        EXPECT_NEAR(layer.length[i + 1], -2 / direction.y - to_mirror, 1e-5);
        expect_near(layer.throughput[i + 1], color * glm::exp(-to_mirror * water.extinction()));
        EXPECT_NEAR(layer.direction[i + 1].x, -direction.x, 1e-6);
    }
}

TEST(SegmentLayer, ACameraAtTheSurfaceLooksIntoTheWater) {
    ViewScene scene(4, 4);
    scatter(scene.fill_flat(40));
    scene.add_floor(-2);
    for (const double height : {0.0, 1e-9, -1e-9}) {
        scene.look({0, height, 0}, {1, -1, 0});
        const SegmentLayer layer = trace(scene).segments;
        ASSERT_EQ(layer.segments(), 16u);
        for (std::size_t i = 0; i < 16; ++i) {
            EXPECT_NEAR(layer.length[i], -2 / direction_of(scene, i).y, 1e-5);
            EXPECT_EQ(layer.throughput[i], glm::vec3(1));
        }
        // Along it and up: finite, and nothing is counted twice.
        scene.look({0, height, 0}, {1, 1e-3, 0});
        const SegmentLayer along = trace(scene).segments;
        for (std::size_t i = 0; i < along.segments(); ++i) {
            EXPECT_TRUE(std::isfinite(along.length[i]));
            EXPECT_GT(along.length[i], 0);
        }
    }
}

TEST(SegmentLayer, AnOrthographicPictureStartsOnBothSidesOfTheWater) {
    ViewScene scene(8, 8);
    scene.look_in_parallel({-5, 0, 0}, {0, -5, 0}, 2);  // 45 degrees down, starts from 0.6 above to 0.6 below
    const scene::Water water = scatter(scene.fill_flat(60));
    scene.add_floor(-6);
    const SegmentLayer layer = trace(scene).segments;
    ASSERT_EQ(layer.segments(), 64u);
    const test::Crossing crossing = test::cross_surface(std::sqrt(0.5), 1, kIndex);
    const Camera camera(scene.camera(), 8, 8);
    for (std::size_t i = 0; i < 64; ++i) {
        glm::dvec3 origin, direction;
        camera.ray(middle_of(i, 8), origin, direction);
        const bool above = origin.y > 0;
        const double expected = above ? 6 / crossing.cos_t : (origin.y + 6) / -direction.y;
        EXPECT_NEAR(layer.length[i], expected, 1e-5);
        expect_near(layer.throughput[i],
                    glm::dvec3(above ? crossing.transmittance / (kIndex * kIndex) : 1.0));
        if (!above) {
            EXPECT_NEAR(length(layer.spread_u_origin[i]), 2.0 / 8, 1e-6);
        }
    }
}

scene::Medium& add_fog(ViewScene& scene, const glm::dvec3& position, const glm::dvec3& size,
                       scene::MediumSide side) {
    scene::Medium fog;
    fog.type = scene::MediumType::box;
    fog.side = side;
    fog.extinction = {0.2, 0.4, 0.8};
    fog.size = size;
    fog.transform.position = position;
    scene.frame.state.media.push_back(fog);
    scene.frame.medium_grids.emplace_back();
    return scene.frame.state.media.back();
}

TEST(SegmentLayer, InTheAirOnlyWhatMeetsAMedium) {
    ViewScene scene(16, 16);
    scene.look_in_parallel({0, 5, 0.01}, {0, 0, 0}, 8);
    scene.fill_flat(40).absorption = {0, 0, 0};
    scene.add_floor(-2);
    add_fog(scene, {0, 2, 0}, {4, 1, 4}, scene::MediumSide::air);
    const SegmentLayer layer = trace(scene).segments, reflected = trace(scene, 1).segments;
    const Camera camera(scene.camera(), 16, 16);
    std::size_t through = 0;
    for (std::size_t pixel = 0; pixel < 256; ++pixel) {
        glm::dvec3 origin, direction;
        camera.ray(middle_of(pixel, 16), origin, direction);
        const bool meets = std::abs(origin.x) < 2 && std::abs(origin.z) < 2;
        through += meets;
        ASSERT_EQ(layer.first[pixel + 1] - layer.first[pixel], meets ? 1u : 0u) << pixel;
        ASSERT_EQ(reflected.first[pixel + 1] - reflected.first[pixel], meets ? 1u : 0u);
        if (!meets) continue;
        const std::uint32_t i = layer.first[pixel], j = reflected.first[pixel];
        EXPECT_EQ(layer.in_water[i], 0);
        EXPECT_EQ(layer.throughput[i], glm::vec3(1));
        EXPECT_NEAR(layer.length[i], origin.y / -direction.y, 1e-5) << "down to the water, box and all";
        // Mirrored, dimmed by the way down and weighed by Fresnel; cut where the box ends, 2.5 m above.
        const test::Crossing crossing = test::cross_surface(-direction.y, 1, kIndex);
        expect_near(
            reflected.throughput[j],
            (1 - crossing.transmittance) * glm::exp(-scene.frame.state.media[0].extinction / -direction.y),
            1e-5);
        EXPECT_GE(reflected.length[j], 2.5 / -direction.y * (1 - kFloat));
        EXPECT_LE(reflected.length[j], 2.5 / -direction.y * 1.002);
    }
    EXPECT_EQ(through, 64u);
}

TEST(SegmentLayer, AMediumInWaterThatDoesNotScatterItself) {
    ViewScene scene(4, 4);
    scene.look_in_parallel({-1, -3, 0}, {0, -3, 0}, 0.5);
    scene::Water& water = scene.fill_flat(40);
    water.absorption = {0, 0, 0};
    scene::Medium& fog = add_fog(scene, {2, -3, 0}, {2, 1, 2}, scene::MediumSide::water);
    SegmentLayer layer = trace(scene).segments;
    ASSERT_EQ(layer.segments(), 16u);
    for (const float length : layer.length) {
        EXPECT_GE(length, 4 * (1 - kFloat));
        EXPECT_LE(length, 4 * 1.002);
    }
    // Water that is black before it hides it.
    water.absorption = {20, 30, 40};
    EXPECT_NEAR(trace(scene).segments.length[0], 24 * std::log(2.0) / 20, 1e-4);
    // Water that scatters too is seen beyond it.
    water.absorption = {0.01, 0.1, 0.1};
    water.scattering = {0.01, 0.01, 0.01};
    EXPECT_NEAR(trace(scene).segments.length[0], 24 * std::log(2.0) / 0.02, 1e-2);
    // What only absorbs is nothing to look at.
    water.scattering = {0, 0, 0};
    fog.albedo = {0, 0, 0};
    EXPECT_EQ(trace(scene).segments.segments(), 0u);
    fog.albedo = {1, 1, 1};
    fog.side = scene::MediumSide::air;
    EXPECT_EQ(trace(scene).segments.segments(), 0u);
}

TEST(SegmentLayer, AWindowIsAPartOfThePicture) {
    ViewScene scene(40, 24);
    scene.look({0.3, -2, 0.2}, {0.3, 0, 0.2}, 2.2);
    scatter(scene.fill_flat(3));
    scene.add_floor(-5, 1000);
    const SegmentLayer whole = trace(scene).segments;
    LayerCounts counts;
    SegmentLayer part;
    const rays::RayScene rays(scene.frame);
    trace_layer(scene.frame, rays, {0, 0, {}, LayerRequest::Window{{7, 5}, {19, 3}}}, counts, &part);
    ASSERT_EQ(part.first.size(), 58u);
    for (std::size_t y = 0; y < 3; ++y) {
        for (std::size_t x = 0; x < 19; ++x) {
            const std::uint32_t a = part.first[y * 19 + x], b = whole.first[(y + 5) * 40 + x + 7];
            ASSERT_EQ(part.first[y * 19 + x + 1] - a, whole.first[(y + 5) * 40 + x + 8] - b);
            EXPECT_EQ(part.length[a], whole.length[b]);
            EXPECT_EQ(part.direction[a], whole.direction[b]);
        }
    }
}

TEST(SegmentLayer, SameBitsOnOneAndTwoThreadsAndReceiversAsWithout) {
    ViewScene scene(70, 45);
    scene.look({0, 0.6, 3}, {0, -0.4, 0});
    scatter(scene.fill(test::wavy_water(6, 100), 6));
    scene.add_floor(-2);
    scene.add(scene::Shape::box, {0, 0, 0});
    scene.add(scene::Shape::sphere, {1, 0, 0}).material.mirror = true;
    const auto same = [](const auto& a, const auto& b) {
        return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
    };
    for (const int branch : {0, 1}) {
        set_thread_count(1);
        const Traced a = trace(scene, branch);
        set_thread_count(2);
        const Traced b = trace(scene, branch);
        set_thread_count(0);
        EXPECT_GT(a.segments.segments(), branch == 0 ? 500u : 20u);
        EXPECT_TRUE(same(a.segments.first, b.segments.first) && same(a.segments.origin, b.segments.origin) &&
                    same(a.segments.length, b.segments.length) &&
                    same(a.segments.throughput, b.segments.throughput) &&
                    same(a.segments.spread_v_direction, b.segments.spread_v_direction));
        const ReceiverLayer without = scene.trace(branch);
        EXPECT_TRUE(same(a.receivers.throughput, without.throughput) &&
                    same(a.receivers.position, without.position));
    }
}

}  // namespace
}  // namespace dapple::view
