#include <gtest/gtest.h>

#include <numeric>

#include "light/caustic_map.h"
#include "light/landing.h"
#include "methods/photon_splatting/splat_builder.h"
#include "methods/splat_scene.h"

namespace dapple {
namespace {

using test::flat_floor;
using test::flat_pool;
using test::flat_transmittance;
using test::kIndex;
using test::level;
using test::look_down;
using test::receivers_on_level;
using test::splat;
using test::splat_level;

TEST(PhotonSplatting, FlatWaterComesOutFlatAtAnyRatioOfPhotonsToPixels) {
    for (const double zenith : {0.0, 50.0})
        // 6 m of water against 2 m in 96 pixels: spacings from 9 pixels to a seventh of one, commensurate or
        // not.
        for (const int resolution : {31, 97, 144, 201, 288, 331, 555, 1000, 2016}) {
            SCOPED_TRACE(testing::Message() << "zenith " << zenith << ", " << resolution);
            scene::FrameScene scene = flat_pool(zenith, resolution);
            look_down(scene, 96, 2);
            const methods::LayerResult result = splat_level(scene, -1.5);
            const glm::dvec3 expected = flat_floor(scene, zenith);
            double worst = 0, mean = 0;
            for (const glm::vec3& e : result.irradiance) {
                const glm::dvec3 error = glm::dvec3(e) / expected - 1.0;
                worst = std::max({worst, std::abs(error.r), std::abs(error.g), std::abs(error.b)});
                mean += error.g;
            }
            mean /= static_cast<double>(result.irradiance.size());
            // Positions in float, of 2^-24 of 6 m each, against a spacing of 6 m / resolution.
            EXPECT_LT(worst, 1e-3);
            EXPECT_NEAR(mean, 0, 1e-5 + 1e-8 * resolution);
        }
}

TEST(PhotonSplatting, MediaDimTheLightOnBothSidesOfTheWater) {
    scene::FrameScene scene = flat_pool(50, 201);
    scene.state.water->scattering = {0.1, 0.2, 0.4};
    look_down(scene, 96, 2);
    const auto expect_floor = [&](double in_fog) {
        const methods::LayerResult result = splat_level(scene, -1.5);
        glm::dvec3 expected = flat_floor(scene, 50);
        if (in_fog > 0) expected *= glm::exp(-in_fog * scene.state.media[0].extinction);
        for (const glm::vec3& e : result.irradiance)
            for (int c = 0; c < 3; ++c)  // as without media
                ASSERT_NEAR(static_cast<double>(e[c]), expected[c], 1e-3 * expected[c]) << in_fog;
    };
    expect_floor(0);
    scene::Medium fog;
    fog.type = scene::MediumType::box;
    fog.size = {100, 0.5, 100};
    fog.transform.position = {1, 0.05, 3};  // from 0.3 m above the surface to 0.2 m below
    fog.extinction = {0.5, 1, 2};
    scene.state.media = {fog};
    const double i = glm::radians(50.0), t = std::asin(std::sin(i) / kIndex);
    expect_floor(0.3 / std::cos(i) + 0.2 / std::cos(t));
    scene.state.media[0].side = scene::MediumSide::air;
    expect_floor(0.3 / std::cos(i));
    scene.state.media[0].side = scene::MediumSide::water;
    expect_floor(0.2 / std::cos(t));
}

TEST(PhotonSplatting, FlatWaterComesOutFlatInPerspective) {
    for (const int resolution : {300, 700, 1500}) {
        SCOPED_TRACE(resolution);
        scene::FrameScene scene = flat_pool(30, resolution);
        look_down(scene, 128, 2);
        scene.state.camera.projection = scene::Projection::perspective;
        scene.state.camera.position = {-1.6, -0.5, 0.7};
        scene.state.camera.target = {-0.2, -1.5, 0};
        scene.state.camera.up = {0, 1, 0};
        scene.state.camera.field_of_view = 0.7;
        const view::ReceiverLayer layer = receivers_on_level(scene, -1.5);
        FrameStats stats;
        const methods::LayerResult result =
            splat(scene, {{0, light::Event::transmission}}, {&layer, 1}, stats)[0];
        const glm::dvec3 expected = flat_floor(scene, 30);
        double worst = 0;
        std::size_t seen = 0;
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            const glm::dvec3 p = glm::dvec3(layer.position[i]) + scene.origin;
            if (std::abs(p.x) > 1.5 || std::abs(p.z) > 1.5) continue;
            worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[i].g) / expected.g - 1));
            ++seen;
        }
        EXPECT_GT(seen, layer.pixels() / 4);
        // Kernels change with the distance: their sum is one but for second differences, which at 2 cm of
        // spacing against 1 m of distance are a few thousandths where bases pass into each other.
        EXPECT_LT(worst, resolution < 500 ? 8e-3 : 4e-3);
    }
}

TEST(PhotonSplatting, LevelReceiversCatchAllFluxOfASea) {
    for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
        const bool down = event == light::Event::transmission;
        scene::FrameScene scene = test::water_scene({4, 4});
        scene.state.lights = {test::sun(down ? 25 : 65, 0)};  // travels along -x
        scene.state.lights[0].irradiance = {1, 1, 1};
        scene.state.water->absorption = {0, 0, 0};
        scene.state.caustics.map.map_resolution = 512;
        // Gentler waves for the reflection: its directions turn by twice the slope, and must all meet the
        // ceiling, which must not shadow the water.
        test::add_water(scene, test::gentle_sea(down ? 0.0032 : 0.001), 200, 200);
        look_down(scene, 512, down ? 10 : 16);
        if (down) {
            scene.state.objects = {level(-2)};
        } else {
            scene.state.objects = {level(2, 14)};
            scene.state.objects[0].transform.position.x = -6;
            scene.state.camera.position = {-6, 0.5, 0};
            scene.state.camera.target = {-6, 2, 0};
        }
        const double height = down ? -2 : 2;
        const methods::LayerResult result = splat_level(scene, height, event);
        double sum = 0;
        for (const glm::vec3& e : result.irradiance) sum += static_cast<double>(e.g);
        sum *= std::pow(scene.state.camera.view_height / 512, 2);
        FrameStats stats;
        light::CausticMapper mapper(test::validated_device());
        const rays::RayScene rays(scene);
        const light::BeamMesh mesh =
            mapper.trace(scene, rays, 0, {event}, scene.state.caustics.map, stats)[0];
        const double flux = std::accumulate(mesh.flux.begin(), mesh.flux.end(), 0.0);
        EXPECT_GT(flux, down ? 10 : 0.5);
        // The samples of single splats ripple with their place; over 2e5 splats that averages out, less well
        // in the reflection, which has folded several times over by there.
        EXPECT_NEAR(sum / flux, 1, down ? 1e-4 : 2e-4) << mesh.name;
    }
}

TEST(PhotonSplatting, FlatWaterComesOutFlatUpToTheEdgesOfSurfaces) {
    // A box on the floor that pierces the surface, met by light that travels along +x: the corner of floor
    // and wall at x = 0.5; or one under water: the edge of its top at x = -0.5.
    for (const bool corner : {true, false}) {
        scene::FrameScene scene = flat_pool(30, 270);
        scene.state.lights[0].direction = {0.5, -std::sqrt(0.75), 0};
        scene.state.water->absorption = {0, 0, 0};
        scene::Object box;
        box.shape = scene::Shape::box;
        box.size = corner ? glm::dvec3(2, 3, 8) : glm::dvec3(1, 0.5, 8);
        box.transform.position = corner ? glm::dvec3(1.5, -0.5, 0) : glm::dvec3(-1, -1.25, 0);
        scene.state.objects.push_back(box);
        look_down(scene, 200, 2);
        const double height = corner ? -1.5 : -1.0;
        view::ReceiverLayer layer = receivers_on_level(scene, height);
        FrameStats stats;
        const methods::LayerResult result =
            splat(scene, {{0, light::Event::transmission}}, {&layer, 1}, stats)[0];
        const double expected = flat_floor(scene, 30).g;
        double worst = 0;
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            const double x = static_cast<double>(layer.position[i].x) + scene.origin.x;
            if (corner ? x > 0.5 : x < -1 || x > -0.5) continue;
            worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[i].g) / expected - 1));
        }
        // Without the photons that landed beyond the edge half the light is missing there.
        EXPECT_LT(worst, 1e-3) << (corner ? "corner" : "edge");
    }
}

TEST(PhotonSplatting, APointLightLightsTheFloorByItsClosedForm) {
    scene::FrameScene scene = test::water_scene({6, 6});
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0.4, 1.2, -0.3};
    lamp.intensity = {7, 7, 7};
    scene.state.lights = {lamp};
    scene.state.water->absorption = {0, 0, 0};
    scene.state.objects = {level(-1.5)};
    scene.state.caustics.map.map_resolution = 600;
    test::add_water(scene, {}, 8, 8);
    look_down(scene, 96, 2);
    const view::ReceiverLayer layer = receivers_on_level(scene, -1.5);
    const methods::LayerResult result = splat_level(scene, -1.5);
    const double a = 1.2, b = 1.5;
    double worst = 0;
    for (std::size_t k = 0; k < layer.pixels(); ++k) {
        const glm::dvec3 p(layer.position[k]);
        const double r = std::hypot(p.x - 0.4, p.z + 0.3);
        double low = 0, high = glm::half_pi<double>();
        for (int step = 0; step < 60; ++step) {  // r(i) grows
            const double i = 0.5 * (low + high);
            (a * std::tan(i) + b * std::tan(std::asin(std::sin(i) / kIndex)) < r ? low : high) = i;
        }
        const double i = std::max(low, 1e-6), t = std::asin(std::sin(i) / kIndex);
        // methods: E = I (1 - F) sin(i) / (r dr/di).
        const double rate =
            a / std::pow(std::cos(i), 2) + b * std::cos(i) / (kIndex * std::pow(std::cos(t), 3));
        const double radius = a * std::tan(i) + b * std::tan(t);
        const double expected = 7 * flat_transmittance(i) * std::sin(i) / (radius * rate);
        worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[k].g) / expected - 1));
    }
    // Spacing of 1 cm against lengths of 1 m: the footprint's and the tent's second differences are 1e-4.
    EXPECT_LT(worst, 1e-3);
}

TEST(PhotonSplatting, LayersHaveTheSameBitsInAnyBatch) {
    scene::FrameScene scene = flat_pool(20, 300);
    test::add_water(scene, test::gentle_sea(), 100, 100);
    look_down(scene, 64, 2);
    scene.state.clip.samples = 5;
    std::vector<view::ReceiverLayer> layers;
    for (int sample = 0; sample < 5; ++sample) layers.push_back(receivers_on_level(scene, -1.5, sample));
    FrameStats stats;
    for (const auto backend : {methods::RasterBackend::host, methods::RasterBackend::device}) {
        const auto together = splat(scene, {{0, light::Event::transmission}}, layers, stats, backend);
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const auto alone =
                splat(scene, {{0, light::Event::transmission}}, {&layers[i], 1}, stats, backend);
            EXPECT_EQ(alone[0].irradiance, together[i].irradiance) << i;
        }
    }
}

TEST(PhotonSplatting, LightsOnlyReceiversInItsMediumThatFaceItOnItsPlane) {
    scene::FrameScene scene = flat_pool(0, 200);
    look_down(scene, 8, 0.5);
    FrameStats stats;
    std::vector<view::ReceiverLayer> layers(7, receivers_on_level(scene, -1.5));
    for (std::size_t i = 0; i < layers[0].pixels(); ++i) {
        layers[1].flags[i] = view::kReceiver;  // in the air
        layers[2].flags[i] = view::kReceiver | view::kInWater | view::kBehindSpecular;
        layers[3].shading_normal[i] = {0, -1, 0};
        layers[4].position[i].y += 0.1f;  // a shelf above the floor
        layers[5].shading_normal[i] = {1, 0, 0};
        layers[6].flags[i] = view::kEnvironment;
    }
    for (const auto backend : {methods::RasterBackend::host, methods::RasterBackend::device}) {
        const auto results = splat(scene, {{0, light::Event::transmission}}, layers, stats, backend);
        for (std::size_t k = 0; k < layers.size(); ++k)
            for (std::size_t i = 0; i < layers[k].pixels(); ++i) {
                EXPECT_EQ(results[k].irradiance[i].g > 0, k == 0) << k;
                EXPECT_EQ(results[k].covered[i], k == 2 || k == 6 ? 0 : 1) << k;
            }
    }
}

TEST(PhotonSplatting, ASceneWithoutChainsIsDark) {
    scene::FrameScene scene = flat_pool(0, 20);
    look_down(scene, 8, 0.5);
    FrameStats stats;
    const view::ReceiverLayer layer = receivers_on_level(scene, -1.5);
    const auto results = splat(scene, {}, {&layer, 1}, stats);
    for (const glm::vec3& e : results[0].irradiance) EXPECT_EQ(e, glm::vec3(0));
    EXPECT_EQ(results[0].covered[0], 1);
}

TEST(PhotonSplatting, NamesTheLightOfFootprintsWithoutArea) {
    // All rays meet in one point of the floor, in floats too.
    scene::FrameScene scene = flat_pool(0, 8);
    scene.origin = {0, 0, 0};
    scene.state.water->absorption = scene.state.water->scattering = {0, 0, 0};
    scene.state.caustics.photon_splatting.footprint = scene::PhotonFootprint::photon_difference;
    look_down(scene, 8, 2);
    light::BeamMesh mesh;
    mesh.rows = mesh.columns = 4;
    mesh.texel = glm::mat2(0.25f);
    for (int i = 0; i < 16; ++i) {
        const int column = i % 4, row = i / 4;
        const glm::vec3 off(static_cast<float>(column), 0, static_cast<float>(row));
        mesh.origin.push_back(0.25f * off);
        mesh.slope.push_back(glm::vec3(0, -1, 0) - 0.125f * off);
    }
    mesh.start.assign(16, 0.0f);
    mesh.flux.assign(16, 0.5f);
    mesh.valid.assign(16, 1);
    light::Landings landings;
    landings.depth.assign(16, 2.0f);
    landings.normal.assign(16, glm::vec3(0, 1, 0));
    for (const bool paper : {false, true}) {
        scene.state.caustics.map.paper_faithful = paper;
        double lost = 0;
        std::size_t splats = 0;
        methods::build_splats(scene, media::Media(scene), mesh, landings,
                              methods::splat_style(scene.state.caustics), 64,
                              [&](const methods::Splats& some) {
                                  lost += some.lost;
                                  for (const auto& band : some.points) splats += band.size();
                                  for (const auto& band : some.quads) splats += band.size();
                              });
        const glm::dvec3 light = scene.state.lights[0].irradiance;
        // By default such footprints are a pixel wide.
        EXPECT_NEAR(lost, paper ? 16 * 0.5 * (light.r + light.g + light.b) / 3 : 0, 1e-5);
        EXPECT_EQ(splats > 0, !paper);
    }
}

}  // namespace
}  // namespace dapple
