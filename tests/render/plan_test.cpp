#include "render/plan.h"

#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"
#include "light/emitters.h"

namespace dapple {
namespace {

/// Serves what it is told to; renders nothing.
class TellingMethod : public methods::CausticMethod {
public:
    using Degree = methods::Support::Degree;
    explicit TellingMethod(bool behind_specular, Degree degree = Degree::partly,
                           Degree volume_degree = Degree::no)
        : behind_specular_(behind_specular), degree_(degree), volume_degree_(volume_degree) {}
    methods::Support supports_surface(const scene::FrameState&) const override {
        return {degree_, "the reason"};
    }
    methods::Support supports_volume(const scene::FrameState&) const override {
        return {.degree = volume_degree_, .reason = "the volume's reason", .in_air = media_in_air_};
    }
    bool serves_behind_specular() const override { return behind_specular_; }
    bool follows_glass() const override { return follows_glass_; }
    TellingMethod& without_media_in_air() {
        media_in_air_ = false;
        return *this;
    }
    TellingMethod& following_glass() {
        follows_glass_ = true;
        return *this;
    }
    std::size_t bytes(const scene::FrameState&, std::size_t) const override { return 0; }
    void begin(methods::FrameContext&) override {}
    void irradiance(methods::FrameContext&, std::span<const view::ReceiverLayer>,
                    std::span<methods::LayerResult>) override {}

private:
    bool behind_specular_;
    bool follows_glass_ = false;
    bool media_in_air_ = true;
    Degree degree_;
    Degree volume_degree_;
};

/// As sliced beams are: all receivers, however the camera sees them.
TellingMethod covering() {
    return TellingMethod(true, methods::Support::Degree::yes);
}

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

TEST(Plan, CreditsAMethodWithMediaOfTheSidesThatItKnows) {
    scene::FrameState state = pool();
    state.water->scattering = glm::dvec3(0.1);
    scene::Medium fog;
    fog.name = "fog";
    fog.type = scene::MediumType::box;
    fog.side = scene::MediumSide::air;
    state.media = {fog};
    scene::FrameScene scene = scene_of(state);
    scene.medium_grids.resize(1);
    using enum methods::Support::Degree;
    TellingMethod knows(true, yes, yes);
    const render::Plan both = render::make_plan(scene, knows);
    EXPECT_EQ(line(both, "sun > water:R").decision, "yes");
    TellingMethod not_in_air(true, yes, yes);
    const render::Plan plan = render::make_plan(scene, not_in_air.without_media_in_air());
    EXPECT_EQ(line(plan, "sun > water:R").decision, "no");
    EXPECT_EQ(line(plan, "sun > water:T").decision, "yes");
    EXPECT_TRUE(plan.volume_caustics);
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

TEST(Plan, AreaLightsThatFaceAwayFromTheWaterAreNotTraced) {
    scene::FrameState state = pool();
    state.lights = {test::quad_panel({0, 1, 0}, {1, 1}, 4)};
    const auto planned = [&](glm::dvec3 direction) {
        state.lights[0].direction = glm::normalize(direction);
        scene::FrameScene scene = scene_of(scene::with_emitter_parts(state));
        auto water = std::make_shared<scene::WaterMesh>();
        water->mesh.positions = {{-2, 0, -2}, {2, 0, -2}, {2, 0.1, 2}, {-2, 0, 2}};
        scene.water = water;
        return render::make_plan(scene, TellingMethod(true));
    };
    EXPECT_EQ(planned({0, -1, 0}).chains.size(), 4u);
    EXPECT_EQ(planned({0, 0, 1}).chains.size(), 4u) << "upright";
    const render::Plan away = planned({0, 1, 0});
    EXPECT_TRUE(away.chains.empty());
    EXPECT_FALSE(away.caustics);
    EXPECT_TRUE(away.direct_light);
    EXPECT_EQ(line(away, "panel > water:T").decision, "no");
    EXPECT_EQ(line(away, "panel > water:T").reason, "all the water lies behind the emitter");
    // From the middle of the emitter to the corner that a wave lifts: 2 m along x and z, 0.9 m down.
    EXPECT_EQ(planned({1, 4.5, 1}).chains.size(), 0u);
    EXPECT_EQ(planned({1, 4.4, 1}).chains.size(), 4u);
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

TEST(Plan, ACameraAtTheSurfaceOfFlatWaterIsUnderIt) {
    scene::FrameState state = pool();
    for (const double height : {0.0, 1e-9, -1e-9}) {
        state.camera.position = {0, height, 0};
        EXPECT_EQ(render::make_plan(scene_of(state), TellingMethod(false)).chains.size(), 1u) << height;
    }
    state.camera.position = {0, 1e-3, 0};
    EXPECT_EQ(render::make_plan(scene_of(state), TellingMethod(false)).chains.size(), 0u);
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

TEST(Plan, SaysOnceByHowManyPointsAnAreaLightShines) {
    scene::FrameState state = pool();
    state.lights = {test::disc_panel({0, 2, 0}, 0.5, 5)};
    const render::Plan plan =
        render::make_plan(scene_of(scene::with_emitter_parts(state)), TellingMethod(false));
    EXPECT_EQ(plan.chains.size(), 5u);
    EXPECT_EQ(line(plan, "panel > water:T").reason, "objects below the water; by 5 points of the disc");
    EXPECT_EQ(std::count_if(plan.lines.begin(), plan.lines.end(),
                            [](const auto& line) { return line.pass == "panel > water:T"; }),
              1);
    EXPECT_NE(line(plan, "not modelled").reason.find("the sun's disc and area lights as seen by the camera"),
              std::string::npos);
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

TEST(Plan, TellsWhatRingsLeaveOut) {
    const TellingMethod method(false);
    scene::FrameScene scene = scene_of(pool());
    auto water = std::make_shared<scene::WaterMesh>();
    water->mesh.triangles.resize(200);
    water->rings = {{0.1, 20, 0}, {0.2, 40, 0.125}, {0.4, 80, 0.125}, {0.8, 1e4, 0.5}};
    scene.water = water;
    EXPECT_EQ(line(render::make_plan(scene, method), "water surface").reason,
              "200 triangles, 4 rings about the camera, cells of 0.1 m to 0.8 m; of the waves' mean-square "
              "slope it leaves out 12.5 % from 20 m on, 50 % from 5000 m on");
}

TEST(Plan, LightsWithoutANameGoByTheirIndex) {
    scene::FrameState state = pool();
    state.lights[0].name.clear();
    const render::Plan plan = render::make_plan(scene_of(state), TellingMethod(false));
    EXPECT_EQ(line(plan, "lights[0] > water:T").decision, "yes");
}

TEST(Plan, AMethodThatCoversAllTracesWhatLandsOnEitherSideOfTheCamera) {
    scene::FrameState state = pool();
    state.objects.push_back(test::level_plane("ceiling", 3, 5));
    for (const double height : {-1.0, 2.0}) {
        state.camera.position = {0, height, 0};
        state.camera.target = {0, height - 1, 0};
        const render::Plan plan = render::make_plan(scene_of(state), covering());
        EXPECT_EQ(plan.chains.size(), 2u);
        EXPECT_EQ(line(plan, "caustics: " + state.caustics.method).decision, "yes");
    }
}

TEST(Plan, TheStandInIsForWhatTheMethodDoesNotLookAt) {
    scene::FrameState state = pool();
    state.water->extent.kind = scene::ExtentKind::pool;
    EXPECT_TRUE(render::make_plan(scene_of(state), TellingMethod(true)).flat_water_stand_in);
    EXPECT_FALSE(render::make_plan(scene_of(state), covering()).flat_water_stand_in);
    state.water->extent.kind = scene::ExtentKind::open_water;
    const render::Plan open = render::make_plan(scene_of(state), covering());
    EXPECT_TRUE(open.flat_water_stand_in);
    EXPECT_EQ(line(open, "flat-water stand-in").reason,
              "beauty only, for light that enters open water beyond its extent (not in E)");
    EXPECT_EQ(line(render::make_plan(scene_of(state), TellingMethod(true)), "flat-water stand-in").reason,
              "beauty only, at receivers in the water that the method does not cover (E and covered are 0 "
              "there), and for light that enters open water beyond its extent (not in E)");
}

TEST(Plan, AMethodThatDoesNotServeTheSceneIsNotRun) {
    const render::Plan plan =
        render::make_plan(scene_of(pool()), TellingMethod(true, methods::Support::Degree::no));
    EXPECT_FALSE(plan.caustics);
    EXPECT_TRUE(plan.chains.empty());
    EXPECT_TRUE(plan.flat_water_stand_in);
    EXPECT_EQ(line(plan, "caustics: " + pool().caustics.method).decision, "no");
    EXPECT_EQ(line(plan, "caustics: " + pool().caustics.method).reason, "the reason");
}

/// Serves receivers and segments.
TellingMethod scattering() {
    return TellingMethod(true, methods::Support::Degree::yes, methods::Support::Degree::partly);
}

scene::FrameScene with_smoke(const scene::FrameState& state) {
    scene::FrameScene scene = scene_of(state);
    scene.state.media.emplace_back().type = scene::MediumType::box;
    scene.state.media.back().transform.position = {0, 2, 0};
    scene.medium_grids.resize(1);
    return scene;
}

TEST(Plan, WithoutMediaThereIsNoVolume) {
    const render::Plan plan = render::make_plan(scene_of(pool()), scattering());
    EXPECT_EQ(line(plan, "volume").decision, "no");
    EXPECT_EQ(line(plan, "volume").reason, "no medium scatters");
    EXPECT_FALSE(plan.volume || plan.volume_caustics || plan.volume_direct || plan.half_volume);
    EXPECT_THROW(line(plan, "volumetric direct light"), std::runtime_error);
    EXPECT_EQ(line(plan, "not modelled").reason.find("media"), std::string::npos);
}

TEST(Plan, WaterThatScattersWantsTheLightThatComesIntoIt) {
    scene::FrameState state = pool();
    state.water->scattering = {0.1, 0.1, 0.1};
    const std::string pass = "volume caustics: " + state.caustics.method;
    const render::Plan plan = render::make_plan(scene_of(state), scattering());
    EXPECT_TRUE(plan.volume && plan.volume_caustics && !plan.volume_direct && plan.caustics);
    EXPECT_EQ(line(plan, pass).decision, "partly");
    EXPECT_EQ(line(plan, pass).reason, "the volume's reason");
    EXPECT_EQ(line(plan, "sun > water:T").reason, "objects and media below the water");
    EXPECT_EQ(line(plan, "sun > water:R").decision, "no");
    EXPECT_EQ(line(plan, "volumetric direct light").decision, "no");
    EXPECT_NE(line(plan, "not modelled").reason.find("light of the sky that media scatter"),
              std::string::npos);

    // Light is traced for it though nothing else is there to be lit.
    state.objects.clear();
    const render::Plan empty = render::make_plan(scene_of(state), scattering());
    ASSERT_EQ(empty.chains.size(), 1u);
    EXPECT_TRUE(empty.volume_caustics);
    EXPECT_FALSE(empty.caustics);
    EXPECT_EQ(line(empty, "sun > water:T").reason, "media below the water");
    EXPECT_EQ(line(empty, "caustics: " + state.caustics.method).decision, "no");

    // A lamp in it lights it directly, and by reflection.
    state.lights[0].type = scene::LightType::point;
    state.lights[0].position = {0, -1, 0};
    const render::Plan lamp = render::make_plan(scene_of(state), scattering());
    EXPECT_TRUE(lamp.volume_direct && lamp.volume_caustics);
    EXPECT_EQ(line(lamp, "volumetric direct light").reason,
              "lights and media in the water, shadowed by objects");
}

TEST(Plan, AMethodThatServesNoSegmentsLeavesTheDirectLight) {
    scene::FrameState state = pool();
    state.objects.clear();
    const render::Plan plan = render::make_plan(with_smoke(state), covering());
    EXPECT_TRUE(plan.chains.empty());
    EXPECT_TRUE(plan.volume && plan.volume_direct && !plan.volume_caustics);
    EXPECT_EQ(line(plan, "volume caustics: " + state.caustics.method).decision, "no");
    EXPECT_EQ(line(plan, "volume caustics: " + state.caustics.method).reason, "the volume's reason");
}

TEST(Plan, SmokeAboveTheWaterWantsReflectedLight) {
    const render::Plan plan = render::make_plan(with_smoke(pool()), scattering());
    EXPECT_EQ(plan.chains.size(), 2u);
    EXPECT_EQ(line(plan, "sun > water:R").reason, "media above the water");
    EXPECT_EQ(line(plan, "sun > water:T").reason, "objects below the water");
    EXPECT_EQ(line(plan, "volumetric direct light").reason,
              "lights and media in the air, shadowed by objects");
    EXPECT_FALSE(plan.half_volume);
    scene::FrameState half = pool();
    half.caustics.volume_resolution = scene::VolumeResolution::half;
    EXPECT_TRUE(render::make_plan(with_smoke(half), scattering()).half_volume);
    EXPECT_FALSE(render::make_plan(scene_of(half), scattering()).half_volume);
}

TEST(Plan, TellsHowEIsFilteredAndWhereItIsFound) {
    scene::FrameState state = pool();
    const render::Plan plain = render::make_plan(scene_of(state), covering());
    EXPECT_EQ(plain.buffer_scale, 1);
    EXPECT_THROW(line(plain, "buffer scale: half"), std::runtime_error);
    EXPECT_THROW(line(plain, "denoise: adaptive"), std::runtime_error);
    state.caustics.buffer_scale = scene::BufferScale::quarter;
    state.caustics.denoise.filter = scene::DenoiseFilter::adaptive;
    const render::Plan plan = render::make_plan(scene_of(state), covering());
    EXPECT_EQ(plan.buffer_scale, 4);
    EXPECT_EQ(line(plan, "buffer scale: quarter").decision, "yes");
    EXPECT_EQ(line(plan, "denoise: adaptive").reason,
              "1 pass, radius 5 to 15 pixels, by luminance; within surfaces, the power of the light is kept");
    state.caustics.denoise.filter = scene::DenoiseFilter::fixed;
    state.caustics.denoise.passes = 10;
    state.caustics.denoise.paper_faithful = true;
    EXPECT_EQ(line(render::make_plan(scene_of(state), covering()), "denoise: fixed").reason,
              "10 passes, radius 5 pixels; as printed, which changes the power of the light: see the counts");
    // Segments have the picture's own pixels.
    const render::Plan scattered = render::make_plan(with_smoke(state), scattering());
    EXPECT_EQ(scattered.buffer_scale, 1);
    EXPECT_EQ(line(scattered, "buffer scale: quarter").decision, "no");
    // Nothing to be lit, nothing to be filtered.
    state.objects.clear();
    const render::Plan empty = render::make_plan(scene_of(state), covering());
    EXPECT_EQ(empty.buffer_scale, 1);
    EXPECT_THROW(line(empty, "denoise: fixed"), std::runtime_error);
}

TEST(Plan, SaysThatALampAmongTheWavesLosesLight) {
    scene::FrameState state = pool();
    state.lights[0].type = scene::LightType::point;
    scene::FrameScene scene = scene_of(state);
    auto water = std::make_shared<scene::WaterMesh>();
    water->largest_height = 0.1;
    scene.water = water;
    const auto reason = [&](double height) {
        scene.state.lights[0].position = {0, height, 0};
        return line(render::make_plan(scene, covering()), height > 0 ? "sun > water:T" : "sun > water:R")
            .reason;
    };
    EXPECT_EQ(reason(0.11), "objects below the water");
    EXPECT_EQ(reason(0.09),
              "objects below the water; the lamp is among the waves and counts as above water: what it sends "
              "onto their other side is lost");
    EXPECT_EQ(reason(-0.09),
              "objects below the water; the lamp is among the waves and counts as under water: what it sends "
              "onto their other side is lost");
}

TEST(Plan, RepeatsTheMethodsOwnWord) {
    const scene::FrameState state = pool();
    const render::PlanLine said =
        line(render::make_plan(scene_of(state), TellingMethod(true)), "caustics: " + state.caustics.method);
    EXPECT_EQ(said.decision, "partly");
    EXPECT_EQ(said.reason, "the reason");
}

scene::Object ball_at(double height) {
    scene::Object ball;
    ball.name = "ball";
    ball.shape = scene::Shape::sphere;
    ball.material.glass = true;
    ball.transform.position = {0, height, 0};
    return ball;
}

TEST(Plan, GlassIsFollowedByMethodsThatDo) {
    scene::FrameState state = pool();
    state.objects.push_back(ball_at(2));
    const render::Plan plan = render::make_plan(scene_of(state), covering().following_glass());
    ASSERT_EQ(plan.chains.size(), 4u);
    EXPECT_EQ(plan.chains[0].object, light::kWater);
    // What the water reflects up may come down again by the ball: there is nothing else above the water.
    EXPECT_EQ(plan.chains[1].event, light::Event::reflection);
    EXPECT_EQ(line(plan, "sun > water:R").reason, "objects below the water");
    EXPECT_EQ(plan.chains[2].object, 1);
    EXPECT_EQ(plan.chains[2].event, light::Event::transmission);
    EXPECT_EQ(plan.chains[3].object, 1);
    EXPECT_EQ(plan.chains[3].event, light::Event::reflection);
    EXPECT_EQ(line(plan, "sun > ball:T").decision, "yes");
    EXPECT_EQ(line(plan, "sun > ball:R").reason, "objects below the water");
    EXPECT_THROW(line(plan, "glass"), std::runtime_error);
}

TEST(Plan, GlassCastsShadowsForOtherMethods) {
    scene::FrameState state = pool();
    state.objects.push_back(ball_at(2));
    const render::Plan plan = render::make_plan(scene_of(state), covering());
    EXPECT_EQ(plan.chains.size(), 1u) << "a ball of glass receives nothing";
    EXPECT_EQ(line(plan, "glass").decision, "no");
    EXPECT_EQ(line(plan, "glass").reason, "the method does not follow light through glass; it casts shadows");
    EXPECT_EQ(line(plan, "sun > water:R").reason, "nothing stands above the water");
    state.lights.clear();
    EXPECT_THROW(line(render::make_plan(scene_of(state), covering()), "glass"), std::runtime_error);
}

TEST(Plan, GlassMakesCausticsWithoutWater) {
    scene::FrameState state = pool();
    state.water.reset();
    state.objects.push_back(ball_at(2));
    const render::Plan plan = render::make_plan(scene_of(state), covering().following_glass());
    ASSERT_EQ(plan.chains.size(), 2u);
    EXPECT_TRUE(plan.caustics);
    EXPECT_FALSE(plan.flat_water_stand_in || plan.volume);
    EXPECT_EQ(line(plan, "sun > ball:T").reason, "objects");
    EXPECT_EQ(line(plan, "caustics: " + state.caustics.method).decision, "yes");

    state.objects.erase(state.objects.begin());  // the floor
    const render::Plan alone = render::make_plan(scene_of(state), covering().following_glass());
    EXPECT_TRUE(alone.chains.empty());
    EXPECT_FALSE(alone.caustics);
    EXPECT_EQ(line(alone, "sun > ball:T").reason, "there is nothing but glass");
}

TEST(Plan, GlassLightsMediaWithoutWater) {
    scene::FrameState state = pool();
    state.water.reset();
    state.objects = {ball_at(2)};
    const render::Plan plan = render::make_plan(with_smoke(state), scattering().following_glass());
    EXPECT_EQ(plan.chains.size(), 2u);
    EXPECT_TRUE(plan.volume && plan.volume_caustics && plan.volume_direct);
    EXPECT_FALSE(plan.caustics);
    EXPECT_EQ(line(plan, "sun > ball:T").reason, "media");
    EXPECT_TRUE(render::make_plan(with_smoke(state), scattering()).chains.empty());
}

TEST(Plan, LightThatGlassInTheWaterSendsOnIsSoughtAboveAndBelow) {
    scene::FrameState state = pool();
    state.objects.push_back(ball_at(0));
    state.objects.push_back(test::level_plane("ceiling", 3, 5));
    const render::Plan plan = render::make_plan(scene_of(state), covering().following_glass());
    EXPECT_EQ(plan.chains.size(), 4u);
    EXPECT_EQ(line(plan, "sun > water:T").reason, "objects above and below the water");
    EXPECT_EQ(line(plan, "sun > ball:T").reason, "objects above and below the water");
}

}  // namespace
}  // namespace dapple
