// The brute-force reference counts light through bodies of glass once, and all of it.
#include <gtest/gtest.h>

#include <array>

#include "methods/reference/light_tracer.h"
#include "methods/reference_glass_frame.h"
#include "scene/transform.h"

namespace dapple {
namespace {

using namespace test;

/// Traces all of one source, and prints where its light went.
reference::EnergyAccount account_of(const scene::FrameState& state, const std::vector<light::Chain>& chains,
                                    std::size_t strata = 1 << 16) {
    GlassFrame frame(state);
    const rays::RayScene rays(frame.scene);
    const reference::ReceiverCharts charts(frame.scene);
    const reference::LightTracer tracer(frame.scene, rays, chains, charts, {});
    EXPECT_EQ(tracer.sources(), 1U);
    const reference::LightPass pass{0, strata};
    const reference::EnergyAccount account = tracer.trace(pass, 0, 0, tracer.strata(pass, 0)).account;
    printf("emitted %.6f: arrived %.6f, escaped %.6f, absorbed %.6f, weak %.2g, long %.2g, astray %.2g\n",
           account.emitted, account.arrived, account.escaped, account.absorbed, account.weak,
           account.long_chains, account.astray);
    return account;
}

/// Of what is emitted all is found, but for 1e-3.
void expect_energy(const reference::EnergyAccount& account, double emitted) {
    EXPECT_NEAR(account.emitted, emitted, 1e-3 * emitted);
    EXPECT_NEAR(account.arrived + account.escaped + account.absorbed, account.emitted,
                1e-3 * account.emitted);
    EXPECT_GT(account.weak, 0);
    EXPECT_EQ(account.left_out, 0);
}

TEST(ReferenceGlass, LightIsOfTheFirstBodyThatItMeets) {
    scene::FrameState state = slab_over_floor(0, glm::dvec3(0), 8);
    state.objects.push_back(state.objects[1]);
    state.objects.back().transform.position.y = 4;
    EXPECT_EQ(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}, 4096).emitted, 0);
    EXPECT_NEAR(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 2 * 2.4 * 1.2, 1e-9);
    // Water over both is met before them.
    state.water.emplace();
    state.water->extent.size = {5, 5};
    state.objects[0].transform.position.y = -5;
    state.objects[1].transform.position.y = -2;
    state.objects[2].transform.position.y = -1;
    EXPECT_EQ(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 0);
    // Under half of the water's rectangle; beside it there is air below a pool's, and open water.
    state.water->extent.center.x = 2.5;
    EXPECT_NEAR(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 2 * 1.2 * 1.2, 0.01);
    state.water->extent.kind = scene::ExtentKind::open_water;
    EXPECT_EQ(account_of(state, {{0, kThrough, 2}, {0, kBack, 2}}, 4096).emitted, 0);
}

TEST(ReferenceGlass, EnergyOfABall) {
    scene::Object ball = glass(scene::Shape::sphere, {0.3, 1.5, -0.2}, 1.5);
    ball.radius = 0.7;
    ball.material.absorption = {0, 0.5, 2};
    scene::FrameState state = floor_below(ball, 0.3, 1, 4);
    state.lights = {sun_from_zenith(35)};
    const double pi = glm::pi<double>();
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}), 2 * pi * 0.49);
    // An ellipsoid, and a disc of 2 degrees: the shadow of x^2/a^2 + y^2 + z^2/c^2 = 1 along unit d has the
    // area pi a c sqrt(dx^2/a^2 + dy^2 + dz^2/c^2), nearly even over the disc.
    state.objects[1].transform.scale = {2, 1, 0.5};
    state.lights[0].angular_diameter = 2 * scene::kDegree;
    const glm::dvec3 d = state.lights[0].direction / glm::dvec3(2, 1, 0.5);
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}), 2 * pi * 0.49 * length(d));
    // A lamp at 3 m: 2 pi I (1 - cos of the angle of the ball).
    state.objects[1].transform.scale = glm::dvec3(1);
    state.lights[0].type = scene::LightType::point;
    state.lights[0].position = glm::dvec3(0.3, 1.5, -0.2) + 3.0 * normalize(glm::dvec3(1, 2, 0.3));
    const double sine = 0.7 / 3;
    expect_energy(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}),
                  2 * pi * 10 * sine * sine / (1 + std::sqrt(1 - sine * sine)));
}

/// W of the lamp's light that meets the block (object 1) or the ball (object 2) first and in the water, by
/// a million directions, evenly over the sphere; no way crosses a crest before.
std::array<double, 2> first_met(const scene::FrameState& state) {
    const Frame frame(state);
    const reference::WaterRays water(frame.scene);
    const scene::Object &block = state.objects[1], &ball = state.objects[2];
    const glm::dvec3 lamp = state.lights[0].position;
    const glm::dmat4 block_from_world =
        glm::inverse(scene::relative_from_object(block.transform, glm::dvec3(0)));
    constexpr int count = 1 << 20;
    std::array<double, 2> met{};
    for (int i = 0; i < count; ++i) {
        const double height = (2 * i + 1.0) / count - 1, angle = 2.399963229728653 * i;
        const double level = std::sqrt(1 - height * height);
        const glm::dvec3 way(level * std::cos(angle), height, level * std::sin(angle));
        const glm::dvec3 o(block_from_world * glm::dvec4(lamp, 1));
        const glm::dvec3 d(block_from_world * glm::dvec4(way, 0));
        const glm::dvec3 a = (-0.5 * block.size - o) / d, b = (0.5 * block.size - o) / d;
        const glm::dvec3 near = glm::min(a, b), far = glm::max(a, b);
        const double enter = std::max({near.x, near.y, near.z}), leave = std::min({far.x, far.y, far.z});
        const glm::dvec3 to_ball = ball.transform.position - lamp;
        const double along = dot(to_ball, way);
        if (along > 0 && dot(to_ball, to_ball) - along * along < ball.radius * ball.radius)
            met[1] += 1;  // the block lies farther away
        else if (enter > 0 && enter < leave && water.in_water(lamp + enter * way - frame.scene.origin))
            met[0] += 1;
    }
    for (double& power : met) power *= 4 * glm::pi<double>() * 10 / count;
    return met;
}

TEST(ReferenceGlass, EnergyOfATurnedBlockInWaves) {
    // A block that straddles waves, under a lamp in the water; all that leaves the water's rectangle escapes.
    scene::FrameState state = small_pool(4, 2, 1, 4);
    state.water->surface.waves.waves = {{0.7, 0.3, 0.02, 0}, {0.4, 1.9, 0.01, 1}};
    state.water->absorption = glm::dvec3(0);
    scene::Object block = glass(scene::Shape::box, {0, 0, 0}, 1.5);
    block.size = {0.8, 0.7, 0.6};
    block.transform.rotation = {0.4, 0.2, 0.7};
    state.objects.push_back(block);
    state.objects.push_back(glass(scene::Shape::sphere, {0.2, -1.2, 0.1}, 1.5));
    state.objects.back().radius = 0.3;
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0.6, -1.3, 0.5};
    state.lights = {lamp};
    const std::array<double, 2> expected = first_met(state);
    for (const int object : {1, 2}) {
        const reference::EnergyAccount account =
            account_of(state, {{0, kThrough, object}, {0, kBack, object}});
        expect_energy(account, expected[static_cast<std::size_t>(object - 1)]);
        EXPECT_GT(account.arrived, 0.05 * account.emitted);
        EXPECT_GT(account.escaped, 0.05 * account.emitted);
    }
}

TEST(ReferenceGlass, ALampInABlockInTheSurface) {
    // Half in the air and half in the water, which its light meets after the glass.
    scene::FrameState state = small_pool(4, 2, 1, 4);
    state.water->absorption = glm::dvec3(0);
    scene::Object block = glass(scene::Shape::box, {0, 0.05, 0}, 1.5);
    block.size = {1, 0.8, 1};
    state.objects.push_back(block);
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    for (const double waves : {0.0, 0.01}) {
        if (waves > 0) state.water->surface.waves.waves = {{0.7, 0.3, waves, 0}};
        for (const double y : {-0.2, 0.2}) {
            lamp.position = {0.1, y, 0.2};
            state.lights = {lamp};
            EXPECT_EQ(account_of(state, {{0, kThrough}, {0, kBack}}).emitted, 0);
            EXPECT_NEAR(account_of(state, {{0, kThrough, 1}, {0, kBack, 1}}).emitted, 40 * glm::pi<double>(),
                        1e-3);
        }
    }
}

/// sr of a rectangle of half sides a and b, seen from the distance d before its middle.
double solid_angle(double a, double b, double d) {
    return 4 * std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d)));
}

TEST(ReferenceGlass, LightOfALampMeetsAFaceInTheSurfaceOrTheWater) {
    // A block with its top or bottom in flat water, and a lamp on that side.
    for (const double side : {1.0, -1.0}) {
        scene::FrameState state = small_pool(4, 2, 1, 4);
        state.water->absorption = glm::dvec3(0);
        scene::Object block = glass(scene::Shape::box, {0, -0.2 * side, 0}, 1.6);
        block.size = {1, 0.4, 0.8};
        state.objects.push_back(block);
        state.objects.push_back(level_plane("ceiling", 1.5, 100));
        scene::Light lamp;
        lamp.type = scene::LightType::point;
        lamp.position = {0, side, 0};
        state.lights = {lamp};
        const double all = 10 * solid_angle(2, 2, 1), face = 10 * solid_angle(0.5, 0.4, 1);
        const reference::EnergyAccount block_first = account_of(state, {{0, kThrough, 1}, {0, kBack, 1}});
        EXPECT_NEAR(block_first.emitted, face, 1e-3 * face);
        EXPECT_LT(block_first.astray, 1e-4 * face);
        const reference::EnergyAccount water_first = account_of(state, {{0, kThrough}, {0, kBack}});
        EXPECT_NEAR(water_first.emitted, all - face, 1e-3 * all);
        // After a ball about the lamp that bends no light the face is the second event. To what the two
        // found comes what meets neither: it reaches the ceiling or the floor, up, and past the water.
        scene::Object ball =
            glass(scene::Shape::sphere, lamp.position, side > 0 ? 1 : state.water->refractive_index);
        ball.radius = 0.3;
        state.objects.push_back(ball);
        const reference::EnergyAccount second = account_of(state, {{0, kThrough, 3}});
        EXPECT_LT(second.astray, 1e-4 * face);
        const double away = side > 0 ? 0.5 : 1, beyond = side > 0 ? 3 : 2.5;
        const double straight = 10 * (solid_angle(50, 50, away) + solid_angle(50, 50, beyond)) - all;
        EXPECT_NEAR(second.arrived, straight + block_first.arrived + water_first.arrived, 1e-3 * all);
    }
}

}  // namespace
}  // namespace dapple
