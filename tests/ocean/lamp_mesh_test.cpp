#include "ocean/lamp_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dapple::ocean {
namespace {

int cells(const scene::FrameState& state) {
    return with_mesh_for_lamps(state).water->mesh_cells;
}

/// Above the middle of 8 by 4 m; as wide as it is far, and straight down.
scene::FrameState with_spot(double height, const char* texture) {
    scene::FrameState state;
    state.water.emplace().extent.size = {8, 4};
    scene::Light& light = state.lights.emplace_back();
    light.type = scene::LightType::spot;
    light.position = {0, height, 0};
    light.cone_angle = std::atan(0.5);
    light.texture = texture;
    return state;
}

TEST(LampMesh, IsAsFineAsItsLampsCallFor) {
    EXPECT_EQ(cells(with_spot(2, "a.exr")), 1024) << "256 for each 2 m";
    EXPECT_EQ(cells(with_spot(2, "")), 384) << "96 for each 2 m";
    EXPECT_EQ(cells(with_spot(0.5, "a.exr")), 1449) << "2.1 million triangles";
    scene::FrameState state = with_spot(2, "");
    state.lights[0].cone_angle = 1.5;
    EXPECT_EQ(cells(state), 100) << "25 for each 2 m";
    state.lights[0].type = scene::LightType::point;
    EXPECT_EQ(cells(state), 100);
    state.lights[0].position = {7, 0, -6};
    EXPECT_EQ(cells(state), 40) << "5 m from the nearest corner";
    state.lights[0].position = {0, 1e-9, 0};
    EXPECT_EQ(cells(state), 1000) << "as if 20 cm above 4 m";
    state.lights[0].position = {0, 0, 0};
    EXPECT_EQ(cells(state), 1000);
    state.lights[0].type = scene::LightType::sun;
    EXPECT_EQ(cells(state), 0);
}

TEST(LampMesh, LampsThatDoNotLightTheWaterLeaveItAlone) {
    scene::FrameState state = with_spot(0.02, "a.exr");
    scene::Light& light = state.lights[0];
    EXPECT_GT(cells(state), 1000);
    light.direction = {0, 1, 0};
    EXPECT_EQ(cells(state), 0) << "straight up";
    light.position.y = -2;
    EXPECT_EQ(cells(state), 1024) << "straight up from below";
    light.direction = {0, -1, 0};
    EXPECT_EQ(cells(state), 0) << "straight down from below";
    light.position.y = 2;
    light.intensity = {0, 0, 0};
    EXPECT_EQ(cells(state), 0) << "dark";
    light.intensity = {0, 0, 1};
    EXPECT_EQ(cells(state), 1024);
    // Its cone is 1 m in radius on the water, whose end is 4 m from the middle along x and 2 m along z.
    for (const double beyond : {0.9, 1.1}) {
        light.position = {4 + beyond, 2, 0};
        EXPECT_EQ(cells(state) > 0, beyond < 1);
        light.position = {0, 2, -2 - beyond};
        EXPECT_EQ(cells(state) > 0, beyond < 1);
        light.position = {4 + beyond / std::sqrt(2), 2, 2 + beyond / std::sqrt(2)};
        EXPECT_EQ(cells(state) > 0, beyond < 1) << "a corner";
    }
    // Horizontally towards the water from beside it: the cone's lower half meets it from 4 m on.
    light.position = {-6, 2, 0};
    light.direction = {1, 0, 0};
    EXPECT_EQ(cells(state), static_cast<int>(std::round(256 * 8 / std::hypot(4.0, 2.0))));
    light.direction = {-1, 0, 0};
    EXPECT_EQ(cells(state), 0);
}

TEST(LampMesh, AreaLightsCountForWhatLiesBeforeThem) {
    scene::FrameState state = with_spot(2, "");
    scene::Light& light = state.lights[0];
    light.type = scene::LightType::quad;
    EXPECT_EQ(cells(state), 100) << "25 for each 2 m";
    light.direction = {0, 1, 0};
    EXPECT_EQ(cells(state), 0) << "away from the water";
    light.position.y = -2;
    EXPECT_EQ(cells(state), 100) << "from below";
    // Upright, so that it lights one half of the water, from its edge on.
    light.position = {1, 2, 0};
    light.direction = {1, 0, 0};
    EXPECT_EQ(cells(state), 100);
    light.position = {-6, 2, 3};
    EXPECT_EQ(cells(state), static_cast<int>(std::round(25 * 8 / std::hypot(2.0, 2.0, 1.0))));
    light.direction = {-1, 0, 0};
    EXPECT_EQ(cells(state), 0);
    // Above the middle, turned up until its plane meets the water at the distance x: then that is nearest.
    light.position = {0, 2, 0};
    int last = 100;
    for (double x = 0; x < 4; x += 0.01) {
        light.direction = glm::normalize(glm::dvec3(2, x, 0));
        const int now = cells(state);
        EXPECT_EQ(now, static_cast<int>(std::round(25 * 8 / std::hypot(x, 2.0))));
        EXPECT_LE(std::abs(now - last), 2) << "without steps";
        last = now;
    }
    light.direction = glm::normalize(glm::dvec3(2, 4.01, 0));
    EXPECT_EQ(cells(state), 0) << "beyond the end of the water";
}

TEST(LampMesh, FollowsLampsWithoutSteps) {
    // Down to where the cap holds; then turned away from the water, until it lights none.
    scene::FrameState state = with_spot(20, "a.exr");
    int last = cells(state), steps = 0;
    const auto step = [&](double most) {
        const int now = cells(state);
        EXPECT_LE(std::abs(now - last), most * last + 1);
        steps += now != last;
        last = now;
    };
    for (scene::Light& light = state.lights[0]; light.position.y > 1; light.position.y *= 0.99) step(0.011);
    EXPECT_GT(steps, 200);
    EXPECT_EQ(last, 1449);
    const double cone = state.lights[0].cone_angle;
    for (double angle = 0; angle < 0.5 * std::numbers::pi + cone; angle += 0.002) {
        state.lights[0].direction = {std::sin(angle), -std::cos(angle), 0};
        // Until its nearest light leaves the water, 4 m away.
        if (angle - cone < std::atan(4 / state.lights[0].position.y)) step(0.02);
    }
    EXPECT_EQ(cells(state), 0);
}

TEST(LampMesh, IsTheTimelinesOrTheWavesWhereThoseAreFiner) {
    scene::FrameState state = with_spot(2, "a.exr");
    state.water->mesh_cells = 5;
    EXPECT_EQ(cells(state), 5);
    state.water->mesh_cells = 0;
    scene::Wave& wave = state.water->surface.waves.waves.emplace_back();
    wave.amplitude = 0.01;
    wave.length = 0.15;
    EXPECT_EQ(cells(state), 0) << "25 cells for each 15 cm are finer";
    wave.length = 1;
    EXPECT_EQ(cells(state), 1024);
    wave.length = 0.01;
    state.lights[0].position.y = 0.5;
    EXPECT_EQ(cells(state), 0) << "at the cap already";
    state.water.reset();
    EXPECT_FALSE(with_mesh_for_lamps(state).water);
}

}  // namespace
}  // namespace dapple::ocean
