#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "adaptive_scene.h"
#include "methods/adaptive_beams/beam_paths.h"
#include "optics/optics.h"

namespace dapple::methods::adaptive_beams {
namespace {

using light::Event;

constexpr unsigned kBoth = 3;

/// A light's view of a body, and what its rays meet.
class Traced {
public:
    Traced(const scene::FrameScene& scene, int body)
        : rays_(scene),
          media_(scene),
          views_(LightViews(scene).of(0, scene.state.lights[0].direction, 1, body)),
          tracer_(scene, rays_, media_, views_.at(0), body, kBoth) {}

    VertexPaths at(glm::dvec2 uv) const {
        VertexPaths found;
        tracer_.trace({&uv, 1}, {&found, 1});
        return found;
    }
    const LightView& view() const { return views_[0]; }
    /// The ray of the view that passes nearest to a point, for a sun.
    glm::dvec2 towards(const glm::dvec3& point) const {
        const glm::dvec3 corner = views_[0].ray({0, 0}).origin, d = views_[0].ray({0, 0}).direction;
        const glm::dmat3 axes(views_[0].ray({1, 0}).origin - corner, views_[0].ray({0, 1}).origin - corner,
                              d);
        return glm::dvec2(glm::inverse(axes) * (point - corner));
    }

private:
    rays::RayScene rays_;
    media::Media media_;
    std::vector<LightView> views_;
    PathTracer tracer_;
};

const LightPath& through(const VertexPaths& ray) {
    return ray.paths[static_cast<std::size_t>(Event::transmission)];
}
const LightPath& mirrored(const VertexPaths& ray) {
    return ray.paths[static_cast<std::size_t>(Event::reflection)];
}

/// Two refractions at a ball by plane trigonometry: light that travels along `d` at the distance `offset`
/// from the centre, towards the unit `e` across d.
struct BallRay {
    glm::dvec3 exit;       ///< m, from the centre
    glm::dvec3 direction;  ///< after it
    BallRay(double radius, double index, double offset, const glm::dvec3& d, const glm::dvec3& e) {
        const double i = std::asin(offset / radius), t = std::asin(offset / (radius * index));
        exit = radius * (std::cos(2 * t - i) * d + std::sin(2 * t - i) * e);
        direction = std::cos(2 * (i - t)) * d - std::sin(2 * (i - t)) * e;
    }
};

TEST(AdaptivePaths, BallRefractsTwice) {
    scene::FrameScene scene;
    const glm::dvec3 center(0.3, 5, -0.2);
    const double radius = 0.5, index = 1.5;
    scene.state.objects.push_back(test::glass_ball(center, radius, index));
    scene.state.lights.push_back(test::sun_at(50));
    const Traced traced(scene, 0);
    const glm::dvec3 d = scene.state.lights[0].direction;
    const glm::dvec3 e = glm::normalize(glm::cross(d, glm::dvec3(0.2, 0.3, 0.9)));
    for (const double offset : {1e-3, 0.1, 0.25, 0.4, 0.49}) {
        const VertexPaths ray = traced.at(traced.towards(center + offset * e));
        ASSERT_TRUE(ray.on_body);
        ASSERT_EQ(through(ray).legs.size(), 1U) << offset;
        const PathLeg& leg = through(ray).legs[0];
        const BallRay expected(radius, index, offset, d, e);
        // In double but for which surface is met, so far better than the 1e-6 of floats.
        EXPECT_LT(glm::length(leg.start - center - expected.exit), 1e-9) << offset;
        EXPECT_LT(glm::length(leg.direction - expected.direction), 1e-9) << offset;
        // Fresnel's shares of two crossings at the same angles are equal.
        const double cos_i = std::sqrt(1 - offset * offset / (radius * radius));
        const double cos_t = optics::f64::transmitted_cosine(cos_i, 1 / index);
        const double share = optics::f64::fresnel_transmittance(cos_i, cos_t, 1 / index);
        EXPECT_NEAR(leg.throughput.y, share * share, 1e-9);
        EXPECT_NEAR(mirrored(ray).legs.at(0).throughput.y, 1 - share, 1e-9);
    }
    // The paraxial focus lies n r / (2 (n - 1)) from the centre; farther in by O(offset^2).
    const double offset = 1e-3 * radius;
    const PathLeg leg = through(traced.at(traced.towards(center + offset * e))).legs.at(0);
    const double to_axis = -glm::dot(leg.start - center, e) / glm::dot(leg.direction, e);
    const double focus = glm::dot(leg.start + to_axis * leg.direction - center, d);
    EXPECT_NEAR(focus, index * radius / (2 * (index - 1)), 1e-5 * radius);
}

TEST(AdaptivePaths, SlabShiftsRaysAndAbsorbs) {
    scene::FrameScene scene;
    scene::Object slab = test::glass_ball({0, 1, 0}, 0, 1.6);
    slab.shape = scene::Shape::box;
    slab.size = {6, 0.3, 6};
    slab.material.absorption = {0.5, 1, 2};
    scene.state.objects.push_back(slab);
    scene.state.lights.push_back(test::sun_at(40));
    const Traced traced(scene, 0);
    const glm::dvec3 top(0.2, 1.15, -0.3);
    const VertexPaths ray = traced.at(traced.towards(top));
    const glm::dvec3 d = scene.state.lights[0].direction;
    const PathLeg& leg = through(ray).legs.at(0);
    EXPECT_LT(glm::length(leg.direction - d), 1e-12);
    const double i = 50 * scene::kDegree, t = std::asin(std::sin(i) / 1.6);
    const glm::dvec3 off = leg.start - top;
    EXPECT_NEAR(glm::length(off - glm::dot(off, d) * d), 0.3 * std::sin(i - t) / std::cos(t), 1e-9);
    const double share = optics::f64::fresnel_transmittance(std::cos(i), std::cos(t), 1 / 1.6);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(leg.throughput[c],
                    share * share * std::exp(-slab.material.absorption[c] * 0.3 / std::cos(t)), 1e-9);
    // What is missing is named: entry = throughput + losses.
    glm::dvec3 sum = leg.throughput;
    for (const LightPath::Loss& loss : through(ray).losses) sum += loss.amount;
    EXPECT_LT(glm::length(sum - through(ray).entry), 1e-12);
    EXPECT_EQ(leg.end, kEndsNowhere);
}

TEST(AdaptivePaths, RaysGoThroughWaterAndABallInIt) {
    scene::FrameScene scene;
    test::add_water(scene, 0);
    const glm::dvec3 center(0.1, -1.2, 0);
    const double radius = 0.4;
    scene.state.objects.push_back(test::glass_ball(center, radius, 1.5));
    scene.state.objects.push_back(test::floor_at(-3, 10));
    scene.state.lights.push_back(test::sun_at(90));
    const Traced traced(scene, light::kWater);
    const double offset = 0.2;
    const VertexPaths ray = traced.at(traced.towards(center + glm::dvec3(0, 0, offset)));
    ASSERT_EQ(through(ray).legs.size(), 2U);
    const PathLeg& first = through(ray).legs[0];
    EXPECT_EQ(first.end, 0);
    EXPECT_TRUE(first.in_water);
    EXPECT_LT(glm::length(first.direction - glm::dvec3(0, -1, 0)), 1e-9);
    const PathLeg& second = through(ray).legs[1];
    EXPECT_TRUE(second.in_water);
    EXPECT_EQ(second.end, 1);
    const BallRay expected(radius, 1.5 / 1.333, offset, {0, -1, 0}, {0, 0, 1});
    EXPECT_LT(glm::length(second.start - center - expected.exit), 1e-9);
    EXPECT_LT(glm::length(second.direction - expected.direction), 1e-9);
    // The leg before dims what goes on.
    const double cos_i = std::sqrt(1 - 0.25), cos_t = optics::f64::transmitted_cosine(cos_i, 1.333 / 1.5);
    const double share = optics::f64::fresnel_transmittance(cos_i, cos_t, 1.333 / 1.5);
    const glm::dvec3 way =
        glm::exp(-scene.state.water->extinction() * (1.2 - std::sqrt(radius * radius - offset * offset)));
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(second.throughput[c], first.throughput[c] * way[c] * share * share, 1e-9);
    // Light that the water mirrors leaves upwards.
    EXPECT_LT(glm::length(mirrored(ray).legs.at(0).direction - glm::dvec3(0, 1, 0)), 1e-9);
    EXPECT_FALSE(mirrored(ray).legs[0].in_water);
}

TEST(AdaptivePaths, BallAtTheSurfaceSendsLightIntoTheWater) {
    // A ball that the surface cuts: light enters from the air and leaves into the water.
    scene::FrameScene scene;
    test::add_water(scene, 0);
    const glm::dvec3 center(0, 0.1, 0);
    scene.state.objects.push_back(test::glass_ball(center, 0.5, 1.5));
    scene.state.lights.push_back(test::sun_at(90));
    const Traced traced(scene, 0);
    const double offset = 0.1;
    const PathLeg leg = through(traced.at(traced.towards(center + glm::dvec3(offset, 0, 0)))).legs.at(0);
    EXPECT_TRUE(leg.in_water);
    // In from air, out into water: angles i, t within the ball, o after it.
    const double i = std::asin(offset / 0.5), t = std::asin(offset / 0.75);
    const double o = std::asin(1.5 / 1.333 * std::sin(t));
    const double turned = (i - t) + (o - t);  // towards the axis at both
    EXPECT_NEAR(leg.direction.x, -std::sin(turned), 1e-9);
    EXPECT_NEAR(leg.direction.y, -std::cos(turned), 1e-9);
}

TEST(AdaptivePaths, AFaceInTheSurfaceOfTheWater) {
    // The block's top or bottom lies in flat water: there is no film of water on it, above or below.
    for (const double middle : {-0.2, 0.2}) {
        for (const double elevation : {90.0, 55.0}) {
            scene::FrameScene scene;
            test::add_water(scene, 0);
            scene::Object block = test::glass_ball({0, middle, 0}, 0, 1.6);
            block.shape = scene::Shape::box;
            block.size = {2, 0.4, 2};
            // In front of it a ball that does not bend light.
            const glm::dvec3 d = test::sun_at(elevation).direction;
            scene.state.objects = {block, test::floor_at(-3, 10), test::glass_ball(-4.0 * d, 0.5, 1)};
            scene.state.lights.push_back(test::sun_at(elevation));
            const double i = (90 - elevation) * scene::kDegree, t = std::asin(std::sin(i) / 1.6);
            const double o = std::asin(std::sin(i) / 1.333);
            const double share = optics::f64::fresnel_transmittance(std::cos(i), std::cos(t), 1 / 1.6) *
                                 optics::f64::fresnel_transmittance(std::cos(t), std::cos(o), 1.6 / 1.333);
            const Traced at_block(scene, 0), at_water(scene, light::kWater), at_ball(scene, 2);
            for (int k = 0; k < 400; ++k) {
                const int row = k / 20, column = k % 20;
                const double x = 0.03 * (column - 9.7), z = 0.03 * (row - 9.7);
                const glm::dvec3 top(x, middle + 0.2, z);
                const VertexPaths first = at_block.at(at_block.towards(top));
                const VertexPaths later = at_ball.at(at_ball.towards(top));
                const VertexPaths beside = at_water.at(at_water.towards({1.5, 0, z}));
                // The ball stands before the block's middle.
                const double off = glm::length(glm::cross(top, d));
                if (off > 0.49 && off < 0.51) continue;
                if (off > 0.5) {
                    ASSERT_TRUE(first.on_body);
                    ASSERT_EQ(through(first).legs.size(), 1U);
                    const PathLeg& leg = through(first).legs[0];
                    EXPECT_TRUE(leg.in_water);
                    EXPECT_EQ(leg.end, 1);
                    EXPECT_NEAR(leg.throughput.y, share, 1e-9);
                    EXPECT_FALSE(mirrored(first).legs.at(0).in_water);
                    EXPECT_EQ(at_water.at(at_water.towards(top)).surface, 0);
                } else {
                    ASSERT_EQ(through(later).legs.size(), 2U);
                    EXPECT_EQ(through(later).legs[0].end, 0);
                    EXPECT_FALSE(through(later).legs[0].in_water);
                    EXPECT_TRUE(through(later).legs[1].in_water);
                    EXPECT_NEAR(through(later).legs[1].throughput.y,
                                through(later).legs[0].throughput.y * share, 1e-9);
                }
                EXPECT_TRUE(beside.on_body);
            }
        }
    }
}

TEST(AdaptivePaths, ALampBelowTheRestPlaneNeedsNoWater) {
    scene::FrameScene scene;
    scene.state.objects.push_back(test::glass_ball({0, -3, 0}, 0.5, 1.5));
    scene.state.lights.push_back(test::lamp_at({0, -1, 0}));
    // In the pool it stands in the water, and beside the pool in the air.
    for (const double x : {0.0, 5.0}) {
        for (const bool water : {false, true}) {
            if (water) test::add_water(scene, 0);
            scene.state.objects[0].transform.position.x = x;
            scene.state.lights[0].position.x = x;
            const Traced traced(scene, 0);
            const VertexPaths ray = traced.at({0.5, 0.5});
            ASSERT_TRUE(ray.on_body);
            EXPECT_EQ(mirrored(ray).legs.at(0).in_water, water && x == 0);
            EXPECT_EQ(through(ray).legs.at(0).in_water, water && x == 0);
            const double step = 0.5 / (water && x == 0 ? 2.833 : 2.5);
            EXPECT_NEAR(mirrored(ray).entry.y, water && x == 0 ? std::pow(0.167 / 2.833, 2) : step * step,
                        1e-9);
            scene.water = nullptr;
            scene.state.water.reset();
        }
    }
}

TEST(AdaptivePaths, NoRayMeetsTheSurfaceThatItLeaves) {
    // Along waves in a low sun: the nearest other wave is centimetres away.
    scene::FrameScene scene;
    test::add_water(scene, 0.01);
    scene.state.lights.push_back(test::sun_at(1.5));
    const Traced waves(scene, light::kWater);
    // And by the outline of a ball, some metres from the origin, where floats are coarser.
    scene::FrameScene ball;
    ball.state.objects.push_back(test::glass_ball({9, 5, -7}, 0.5, 1.5));
    ball.state.lights.push_back(test::sun_at(50));
    const Traced outline(ball, 0);
    const glm::dvec3 across =
        0.5 * glm::normalize(glm::cross(ball.state.lights[0].direction, glm::dvec3(0.2, 0.3, 0.9)));
    std::size_t met = 0, rim = 0;
    for (int k = 0; k < 2000; ++k) {
        const double part = (k + 0.5) / 2000;
        const VertexPaths ray = waves.at({part, std::fmod(0.618034 * k, 1.0)});
        if (ray.on_body) {
            ++met;
            for (const LightPath* path : {&through(ray), &mirrored(ray)})
                EXPECT_TRUE(path->legs.at(0).end == kEndsNowhere || path->legs[0].length > 1e-3) << k;
        }
        const VertexPaths grazing =
            outline.at(outline.towards(glm::dvec3(9, 5, -7) + (1 - 1e-3 * part) * across));
        if (!grazing.on_body) continue;
        ++rim;
        EXPECT_EQ(through(grazing).legs.size(), 1U) << k;
        EXPECT_EQ(mirrored(grazing).legs.at(0).end, kEndsNowhere) << k;
    }
    EXPECT_GT(met, 1000U);
    EXPECT_GT(rim, 1900U);
}

TEST(AdaptivePaths, ALampInABallShinesOut) {
    // From the middle of a ball, in air or in water, rays leave it as they are.
    for (const bool water : {false, true}) {
        scene::FrameScene scene;
        if (water) test::add_water(scene, 0);
        const glm::dvec3 center(0.2, -1, 0);
        scene.state.objects.push_back(test::glass_ball(center, 0.4, 1.5));
        scene.state.objects[0].material.absorption = {0.5, 1, 2};
        scene.state.lights.push_back(test::lamp_at(center));
        const double n = water ? 1.333 : 1;
        const double lost = std::pow((1.5 - n) / (1.5 + n), 2);
        const Traced traced(scene, 0);
        for (const glm::dvec2 uv : {glm::dvec2(0.5, 0.5), {0.1, 0.7}}) {
            const VertexPaths ray = traced.at(uv);
            ASSERT_TRUE(ray.on_body);
            const glm::dvec3 d = traced.view().ray(uv).direction;
            const PathLeg& out = through(ray).legs.at(0);
            EXPECT_LT(glm::length(out.direction - d), 1e-9);
            EXPECT_LT(glm::length(out.start - center - 0.4 * d), 1e-9);
            EXPECT_EQ(out.in_water, water);
            const PathLeg& back = mirrored(ray).legs.at(0);
            EXPECT_LT(glm::length(back.direction + d), 1e-9);
            EXPECT_LT(glm::length(back.start - center + 0.4 * d), 1e-9);
            EXPECT_EQ(back.in_water, water);
            for (int c = 0; c < 3; ++c) {
                const double way = std::exp(-0.4 * scene.state.objects[0].material.absorption[c]);
                EXPECT_NEAR(out.throughput[c], way * (1 - lost), 1e-9);
                EXPECT_NEAR(back.throughput[c], way * way * way * lost * (1 - lost), 1e-9);
            }
        }
    }
}

TEST(AdaptivePaths, WaterWithinGlassIsNone) {
    // A lamp in a block that reaches from the water into the air: what lies above it is the block's top.
    scene::FrameScene scene;
    test::add_water(scene, 0);
    scene::Object block = test::glass_ball({0, 0, 0}, 0, 1.5);
    block.shape = scene::Shape::box;
    block.size = {1, 0.8, 1};
    scene.state.objects.push_back(block);
    scene.state.lights.push_back(test::lamp_at({0.1, -0.21, 0}));
    const Traced at_water(scene, light::kWater), at_block(scene, 0);
    for (int k = 0; k < 100; ++k) {
        const int row = k / 10, column = k % 10;
        const glm::dvec2 uv((column + 0.5) / 10, (row + 0.5) / 10);
        EXPECT_FALSE(at_water.at(uv).on_body);
        const VertexPaths ray = at_block.at(uv);
        EXPECT_TRUE(ray.on_body);
        // The first face of the cube about the lamp looks along x: rays leave where that side is wet or dry.
        if (through(ray).legs.empty()) continue;
        EXPECT_EQ(through(ray).legs[0].in_water, through(ray).legs[0].start.y < 0);
    }
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
