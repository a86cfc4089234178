#include "scene/area_light.h"

#include <gtest/gtest.h>

#include "light/emitters.h"

namespace dapple::scene {
namespace {

std::vector<Light> parts_of(const Light& light) {
    FrameState state;
    state.lights = {light};
    return with_emitter_parts(state).lights;
}

std::vector<Light> emitters() {
    std::vector<Light> all = {test::quad_panel({1, 3, -2}, {2, 0.7}, 1),
                              test::disc_panel({1, 3, -2}, 0.8, 1)};
    for (Light& light : all) {
        light.direction = glm::normalize(glm::dvec3(0.3, -1, 0.5));
        light.roll = 0.4;
    }
    return all;
}

TEST(AreaLight, IsCutIntoPartsOfEqualLightWhoseMomentsAreThoseOfTheirPoints) {
    for (Light light : emitters())
        for (light.samples = 1; light.samples < 40; light.samples += light.samples < 8 ? 1 : 5) {
            SCOPED_TRACE(light.samples);
            const std::vector<Light> parts = parts_of(light);
            ASSERT_EQ(parts.size(), static_cast<std::size_t>(light.samples));
            glm::dvec3 intensity(0);
            double area = 0;
            for (const Light& part : parts) {
                intensity += part.intensity;
                const glm::dvec2 size = part.part.high - part.part.low;
                area += size.x * size.y;
                EXPECT_NEAR(size.x * size.y, 1.0 / light.samples, 1e-15);
                // 64 x 64 points: the midpoint rule in each coordinate of a disc is as good as 1e-4.
                constexpr int kSteps = 64;
                glm::dvec3 mean(0);
                glm::dmat3 spread(0);
                for (int i = 0; i < kSteps * kSteps; ++i) {
                    const glm::dvec2 place = (glm::dvec2(i % kSteps, i / kSteps) + 0.5) / double{kSteps};
                    const glm::dvec3 off = emitter_point(part, place) - part.position;
                    EXPECT_NEAR(glm::dot(emitter_point(part, place) - light.position, light.direction), 0,
                                1e-14);
                    EXPECT_LE(glm::length(emitter_point(part, place) - light.position),
                              emitter_reach(light) + 1e-14);
                    mean += off / double{kSteps * kSteps};
                    spread += glm::outerProduct(off, off) / double{kSteps * kSteps};
                }
                EXPECT_LT(glm::length(mean), 3e-4);
                const glm::dmat3 told = glm::outerProduct(part.part.spread_u, part.part.spread_u) +
                                        glm::outerProduct(part.part.spread_v, part.part.spread_v);
                for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(told[c] - spread[c]), 3e-4);
            }
            EXPECT_NEAR(area, 1, 1e-14);
            const glm::dvec3 expected = light.radiance * emitter_area(light);
            EXPECT_LT(glm::length(intensity - expected), 1e-13 * glm::length(expected));
        }
}

TEST(AreaLight, IsSeenUprightByWhatItShinesAt) {
    Light quad = test::quad_panel({0, 3, 0}, {4, 2}, 1);
    quad.part = parts_of(quad)[0].part;
    // Straight down: +x is right and -z is up.
    EXPECT_LT(glm::length(emitter_point(quad, {1, 0.5}) - glm::dvec3(2, 3, 0)), 1e-15);
    EXPECT_LT(glm::length(emitter_point(quad, {0.5, 1}) - glm::dvec3(0, 3, -1)), 1e-15);
    quad.roll = 90 * kDegree;  // clockwise, as it sees its light: its right edge is now down
    EXPECT_LT(glm::length(emitter_point(quad, {1, 0.5}) - glm::dvec3(0, 3, 2)), 1e-15);
    quad.roll = 0;
    quad.direction = {0, 0, -1};  // level: y is up
    EXPECT_LT(glm::length(emitter_point(quad, {0.5, 1}) - glm::dvec3(0, 4, 0)), 1e-15);
    EXPECT_LT(glm::length(emitter_point(quad, {1, 0.5}) - glm::dvec3(2, 3, 0)), 1e-15);
}

TEST(AreaLight, LeavesOtherLightsAndTheirNames) {
    FrameState state;
    state.lights.resize(3);
    state.lights[0].type = LightType::point;
    state.lights[1] = test::disc_panel({0, 2, 0}, 1, 5);
    state.lights[1].name.clear();
    EXPECT_EQ(with_emitter_parts(FrameState()).lights.size(), 0u);
    const FrameState parts = with_emitter_parts(state);
    ASSERT_EQ(parts.lights.size(), 7u);
    EXPECT_EQ(parts.lights[0].name, "lights[0]");
    for (std::size_t i = 1; i < 6; ++i) EXPECT_EQ(parts.lights[i].name, "lights[1]");
    EXPECT_EQ(parts.lights[6].name, "lights[2]");
    EXPECT_EQ(parts.lights[6].part.count, 0);
    EXPECT_EQ(with_emitter_parts(parts).lights.size(), 7u) << "once is enough";
}

}  // namespace
}  // namespace dapple::scene
