#include "render/plan.h"

#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

/// Serves what it is told to; renders nothing.
class TellingMethod : public methods::CausticMethod {
public:
    explicit TellingMethod(bool behind_specular) : behind_specular_(behind_specular) {}
    methods::Support supports_surface(const scene::FrameState&) const override {
        return {methods::Support::Degree::partly, "the reason"};
    }
    bool serves_behind_specular() const override { return behind_specular_; }
    std::size_t bytes(const scene::FrameState&, std::size_t) const override { return 0; }
    void begin(methods::FrameContext&) override {}
    void irradiance(methods::FrameContext&, std::span<const view::ReceiverLayer>,
                    std::span<methods::LayerResult>) override {}

private:
    bool behind_specular_;
};

const render::PlanLine& line(const render::Plan& plan, const std::string& pass) {
    for (const render::PlanLine& candidate : plan.lines) {
        if (candidate.pass == pass) return candidate;
    }
    throw std::runtime_error("no line " + pass);
}

/// The scene of a state over flat water: what the plan looks at.
scene::FrameScene scene_of(const scene::FrameState& state) {
    scene::FrameScene scene;
    scene.state = state;
    if (state.water) scene.water = std::make_shared<scene::WaterMesh>();
    scene.object_meshes.resize(state.objects.size());
    return scene;
}

scene::FrameState pool() {
    scene::FrameState state = test::pool_over_floor(4, 2, 1, 8);
    state.lights = {test::sun_from_zenith(20)};
    return state;
}

TEST(Plan, NoWaterNoCaustics) {
    scene::FrameState state = pool();
    state.water.reset();
    const render::Plan plan = render::make_plan(scene_of(state), TellingMethod(true));
    EXPECT_TRUE(plan.chains.empty());
    EXPECT_FALSE(plan.caustics);
    EXPECT_FALSE(plan.flat_water_stand_in);
    EXPECT_EQ(line(plan, "water surface").decision, "no");
}

TEST(Plan, ReflectedLightIsTracedOnlyWhereSomethingStandsAboveTheWater) {
    scene::FrameState state = pool();
    const render::Plan below = render::make_plan(scene_of(state), TellingMethod(true));
    ASSERT_EQ(below.chains.size(), 1u);
    EXPECT_EQ(below.chains[0].event, light::Event::transmission);
    EXPECT_EQ(line(below, "sun > water:R").decision, "no");
    state.objects.push_back(test::level_plane("ceiling", 3, 5));
    EXPECT_EQ(render::make_plan(scene_of(state), TellingMethod(true)).chains.size(), 2u);
}

TEST(Plan, AMethodOfDirectViewsNeedsOnlyTheCamerasSideOfTheWater) {
    scene::FrameState state = pool();
    state.objects.push_back(test::level_plane("ceiling", 3, 5));
    const render::Plan plan = render::make_plan(scene_of(state), TellingMethod(false));
    ASSERT_EQ(plan.chains.size(), 1u);
    EXPECT_EQ(plan.chains[0].event, light::Event::transmission);
    state.camera.position = {0, 1, 0};
    state.camera.target = {0, 2, 0};
    const render::Plan above = render::make_plan(scene_of(state), TellingMethod(false));
    ASSERT_EQ(above.chains.size(), 1u);
    EXPECT_EQ(above.chains[0].event, light::Event::reflection);
}

TEST(Plan, AnOrthographicCameraMaySeeBothSidesOfTheWater) {
    scene::FrameState state = pool();
    state.objects.push_back(test::level_plane("ceiling", 3, 5));
    for (const double height : {0.5, -0.5}) {
        state.camera.position = {0, height, 1};
        state.camera.target = {0, height, 0};
        state.camera.up = {0, 1, 0};
        state.camera.view_height = 2;
        EXPECT_EQ(render::make_plan(scene_of(state), TellingMethod(false)).chains.size(), 2u);
        state.camera.view_height = 0.8;
        EXPECT_EQ(render::make_plan(scene_of(state), TellingMethod(false)).chains.size(), 1u);
    }
}

TEST(Plan, LightsUnderWaterTransmitUpwards) {
    scene::FrameState state = pool();
    state.lights[0].type = scene::LightType::point;
    state.lights[0].position = {0, -1, 0};
    const render::Plan plan = render::make_plan(scene_of(state), TellingMethod(true));
    ASSERT_EQ(plan.chains.size(), 1u);
    EXPECT_EQ(plan.chains[0].event, light::Event::reflection);
}

TEST(Plan, TellsOfTheWaterWhatItsMeshLacks) {
    const TellingMethod method(false);
    scene::FrameScene scene = scene_of(pool());
    auto water = std::make_shared<scene::WaterMesh>();
    water->mesh.triangles.resize(200);
    scene.water = water;
    EXPECT_EQ(line(render::make_plan(scene, method), "water surface").reason, "200 triangles");
    water->cells_per_shortest_wave = 7.25;
    water->capped = true;
    water->folded_vertices = 3;
    EXPECT_EQ(line(render::make_plan(scene, method), "water surface").reason,
              "200 triangles, 7.2 cells a shortest wave, capped: finer waves want mesh_cells, folded over "
              "itself in places");
}

TEST(Plan, LightsWithoutANameGoByTheirIndex) {
    scene::FrameState state = pool();
    state.lights[0].name.clear();
    const render::Plan plan = render::make_plan(scene_of(state), TellingMethod(false));
    EXPECT_EQ(line(plan, "lights[0] > water:T").decision, "yes");
}

TEST(Plan, RepeatsTheMethodsOwnWord) {
    const render::PlanLine said =
        line(render::make_plan(scene_of(pool()), TellingMethod(true)), "caustics: photon_splatting");
    EXPECT_EQ(said.decision, "partly");
    EXPECT_EQ(said.reason, "the reason");
}

}  // namespace
}  // namespace dapple
