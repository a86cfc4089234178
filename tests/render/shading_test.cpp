#include "render/shading.h"

#include <gtest/gtest.h>

#include "render/flat_water.h"

#include "closed_form/flat_scene.h"
#include "light/gobo.h"

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
                 scene, media::Media(scene), rays, layer, std::vector<std::uint8_t>(layer.pixels(), covered)))
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

/// A slab of fog, 100 m wide, about height `y`.
scene::Medium fog(double y, double thickness) {
    scene::Medium medium;
    medium.type = scene::MediumType::box;
    medium.size = {100, thickness, 100};
    medium.transform.position.y = y;
    medium.extinction = {0.5, 1, 2};
    return medium;
}

void expect_near(const glm::vec3& found, const glm::dvec3& expected) {
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<double>(found[c]), expected[c], 2e-7 * expected[c]);  // round-off to float
}

TEST(FlatWaterStandIn, IsDimmedOnBothSidesOfTheSurface) {
    scene::FrameScene scene;
    scene.state = test::pool_over_floor(100, 2, 1, 8);
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    const scene::Light sun = test::sun_from_zenith(40);
    scene.state.lights = {sun};
    scene.state.media = {fog(0.2, 1)};  // from 0.7 m above the rest plane to 0.3 m below
    scene.object_meshes.resize(1);
    const rays::RayScene rays(scene);
    const test::FlatFloor floor = test::flat_floor(40, 2, scene.state.water->refractive_index);
    const double in_fog = 0.7 / std::cos(glm::radians(40.0)) + 0.3 / 2 * floor.way;
    const auto found =
        render::flat_water_irradiance(scene, media::Media(scene), rays, floor_points({0, 1}, -2), {0, 0});
    for (const glm::vec3& value : found)
        expect_near(value, sun.irradiance * floor.irradiance *
                               glm::exp(-floor.way * scene.state.water->extinction() -
                                        in_fog * scene.state.media[0].extinction));
}

TEST(DirectLight, IsDimmedByMediaInTheAir) {
    scene::FrameScene scene;
    scene.origin = {5, 0, -3};
    scene::Light sun = test::sun_from_zenith(30), lamp;
    lamp.type = scene::LightType::point;
    lamp.position = scene.origin + glm::dvec3(0, 3, 0);
    lamp.intensity = {9, 18, 27};
    scene.state.media = {fog(1, 0.5)};
    scene.state.media[0].transform.position += scene.origin;
    const rays::RayScene rays(scene);
    view::ReceiverLayer layer = floor_points({0}, 0);
    layer.flags[0] = view::kReceiver;
    const glm::dvec3 extinction = scene.state.media[0].extinction;
    const double cosine = std::cos(glm::radians(30.0));
    scene.state.lights = {sun};
    expect_near(render::direct_irradiance(scene, media::Media(scene), rays, layer)[0],
                cosine * sun.irradiance * glm::exp(-0.5 / cosine * extinction));
    scene.state.lights = {lamp};
    expect_near(render::direct_irradiance(scene, media::Media(scene), rays, layer)[0],
                lamp.intensity / 9.0 * glm::exp(-0.5 * extinction));
    scene.state.lights[0].position.y = 1;  // in the fog
    expect_near(render::direct_irradiance(scene, media::Media(scene), rays, layer)[0],
                lamp.intensity * glm::exp(-0.25 * extinction));
}

TEST(DirectLight, IsDimmedByTheWaterAndWhatIsInIt) {
    scene::FrameScene scene;
    scene.state = test::pool_over_floor(100, 4, 1, 8);
    scene.state.water->scattering = {0.1, 0.2, 0.3};
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0, -1, 0};
    lamp.intensity = {9, 18, 27};
    scene.state.lights = {lamp};
    scene.state.media = {fog(-2, 0.5)};
    scene.object_meshes.resize(1);
    const rays::RayScene rays(scene);
    expect_near(render::direct_irradiance(scene, media::Media(scene), rays, floor_points({0}, -4))[0],
                lamp.intensity / 9.0 *
                    glm::exp(-3.0 * scene.state.water->extinction() - 0.5 * scene.state.media[0].extinction));
}

/// Light that glass lets through is caustic light.
TEST(DirectLight, IsKeptOffByGlass) {
    scene::FrameScene scene;
    scene.state.lights = {test::sun_from_zenith(0)};
    scene::Object ball;
    ball.shape = scene::Shape::sphere;
    ball.material.glass = true;
    ball.transform.position = {0, 2, 0};
    scene.state.objects = {ball};
    scene.object_meshes.resize(1);
    const rays::RayScene rays(scene);
    view::ReceiverLayer layer = floor_points({0, 0.49f, 0.51f}, 0);
    layer.flags.assign(3, view::kReceiver);
    const auto found = render::direct_irradiance(scene, media::Media(scene), rays, layer);
    EXPECT_EQ(found[0], glm::vec3(0));
    EXPECT_EQ(found[1], glm::vec3(0));
    expect_near(found[2], scene.state.lights[0].irradiance);
}

TEST(DirectLight, OfASpotFollowsItsPicture) {
    scene::FrameScene scene;
    scene.state.lights = {test::spot({0, 3, 0}, {0, 0, 0})};
    scene.light_textures = {test::picture(64, 64, [](float u, float v) { return glm::vec3(u, v, 1); })};
    const rays::RayScene rays(scene);
    view::ReceiverLayer layer = floor_points({-1.4f, -0.3f, 0, 0.8f, 1.4f, 1.8f}, 0);
    layer.flags.assign(layer.pixels(), view::kReceiver);
    layer.footprint_u.assign(layer.pixels(), glm::vec3(0));
    layer.footprint_v.assign(layer.pixels(), glm::vec3(0));
    for (std::size_t i = 0; i < layer.pixels(); ++i) layer.position[i].z = 0.5f * layer.position[i].x;
    const auto found = render::direct_irradiance(scene, media::Media(scene), rays, layer);
    const double radius = 3 * std::tan(30 * scene::kDegree);  // of the lit circle, m
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const double x = layer.position[i].x, z = layer.position[i].z;
        const double square = 9 + x * x + z * z, e = 3 / (square * std::sqrt(square));  // cos / r^2
        if (x * x + z * z > radius * radius) {
            EXPECT_EQ(found[i], glm::vec3(0));
            continue;
        }
        // -z is up in the picture.
        const glm::dvec3 picture(0.5 + 0.5 * x / radius, 0.5 - 0.5 * z / radius, 1);
        expect_near(found[i] / glm::vec3(picture), e * scene.state.lights[0].intensity);
    }
    // A pixel as wide as the circle sees the mean, which is that of the middle.
    layer.footprint_u.assign(layer.pixels(), glm::vec3(10, 0, 0));
    layer.footprint_v.assign(layer.pixels(), glm::vec3(0, 0, 10));
    const auto wide = render::direct_irradiance(scene, media::Media(scene), rays, layer);
    EXPECT_NEAR(wide[3].r, 0.5f / (0.5f + 0.4f / static_cast<float>(radius)) * found[3].r, 1e-6f);
}

TEST(FlatWaterStandIn, OfASpotFollowsItsPicture) {
    scene::FrameScene scene;
    scene.state = test::pool_over_floor(100, 2, 1, 8);
    const scene::Light spot = test::spot({0, 3, 0}, {0, 0, 0});
    scene.state.lights = {spot};
    scene.object_meshes.resize(1);
    const rays::RayScene rays(scene);
    view::ReceiverLayer layer = floor_points({-1.5f, 0.7f}, -2);
    layer.footprint_u.assign(2, glm::vec3(0));
    layer.footprint_v.assign(2, glm::vec3(0));
    const auto light = [&] {
        return render::flat_water_irradiance(scene, media::Media(scene), rays, layer, {0, 0});
    };
    const auto plain = light();
    scene.light_textures = {test::picture(64, 64, [](float u, float v) { return glm::vec3(u, v, 1); })};
    const auto found = light();
    for (std::size_t i = 0; i < 2; ++i) {
        const double x = layer.position[i].x;
        const auto flat = render::through_flat_water(spot, glm::dvec3(x, -2, 0), 1.333);
        const double u = 0.5 + 0.5 * flat->entry.x / (3 * std::tan(spot.cone_angle));
        expect_near(found[i], glm::dvec3(plain[i]) * glm::dvec3(u, 0.5, 1));
    }
}

TEST(SkyTerm, OfAReceiverInGlassThatStandsInTheWater) {
    scene::FrameScene scene;
    scene.state = test::pool_over_floor(4, 2, 1, 8);
    scene.state.water->extent.kind = scene::ExtentKind::pool;
    scene.state.sky.radiance = {1, 1, 1};
    view::ReceiverLayer layer = floor_points({0, 0, 3}, -1);
    layer.flags[1] = layer.flags[2] = view::kReceiver | view::kInGlass;
    const auto found = render::sky_irradiance(scene, layer);
    EXPECT_EQ(found[1], found[0]);
    EXPECT_GT(found[2].x, 1.2f * found[0].x) << "beside the pool";
}

}  // namespace
}  // namespace dapple
