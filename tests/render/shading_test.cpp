#include "render/shading.h"

#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

/// Receivers in a row along x on a level floor.
view::ReceiverLayer floor_points(const std::vector<float>& along_x, float height) {
    view::ReceiverLayer layer;
    layer.width = static_cast<int>(along_x.size());
    layer.height = 1;
    const std::size_t count = along_x.size();
    layer.flags.assign(count, view::kReceiver | view::kInWater);
    layer.object.assign(count, 0);
    for (const float x : along_x) layer.position.emplace_back(x, height, 0);
    layer.geometric_normal.assign(count, glm::vec3(0, 1, 0));
    layer.shading_normal.assign(count, glm::vec3(0, 1, 0));
    return layer;
}

TEST(FlatWaterStandIn, DoesNotCountTwiceWhatTheMethodCovers) {
    scene::FrameScene scene;
    scene.state = test::pool_over_floor(4, 2, 1, 8);
    scene.state.lights = {test::sun_from_zenith(40)};
    scene.object_meshes.resize(1);
    const rays::RayScene rays(scene);
    // The light goes along +x; it enters 1.11 m before the floor points (2 m tan t, sin t = sin 40 deg / n):
    // outside of +-2 m for the first and the last, inside for the others.
    const view::ReceiverLayer layer = floor_points({-1.5f, -0.5f, 0.5f, 2.5f, 3.5f}, -2);
    const test::FlatFloor expected = test::flat_floor(40, 2, scene.state.water->refractive_index);
    const double lit = 3 * expected.irradiance * std::exp(-0.4 * expected.way);  // the red channel
    const auto stand_in = [&](scene::ExtentKind kind, std::uint8_t covered) {
        scene.state.water->extent.kind = kind;
        std::vector<float> red;
        for (const glm::vec3& value : render::flat_water_irradiance(
                 scene, rays, layer, std::vector<std::uint8_t>(layer.pixels(), covered)))
            red.push_back(value.x);
        return red;
    };
    const auto expect = [&](const std::vector<float>& found, const std::vector<bool>& wanted) {
        for (std::size_t i = 0; i < wanted.size(); ++i)  // 1e-6: round-off to float
            EXPECT_NEAR(found[i], wanted[i] ? lit : 0, 1e-6) << i;
    };
    using enum scene::ExtentKind;
    expect(stand_in(pool, 1), {false, false, false, false, false});
    expect(stand_in(pool, 0), {false, true, true, true, false});
    expect(stand_in(open_water, 1), {true, false, false, false, true});
    expect(stand_in(open_water, 0), {true, true, true, true, true});
}

}  // namespace
}  // namespace dapple
