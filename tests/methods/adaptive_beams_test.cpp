// The class AdaptiveBeams on flat water: E and S of whole frames, and where beams end.
#include "methods/adaptive_beams/adaptive_beams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "methods/adaptive_beams/bounded_beams.h"
#include "methods/adaptive_frame.h"
#include "render/segment_lattice.h"
#include "view/camera_paths.h"

namespace dapple {
namespace {

using namespace test::adaptive_frame;

TEST(AdaptiveBeamsClass, HasTheClosedFormInEverySample) {
    scene::FrameScene scene = pool(50);
    scene.state.water->absorption = {0.4, 0.1, 0.03};
    scene.state.water->scattering = {0.2, 0.3, 0.05};
    scene.state.clip.samples = 2;
    Frame frame(scene);
    const glm::dvec3 extinction = scene.state.water->extinction(), sun = scene.state.lights[0].irradiance;
    const double cos_t = -direction_in_water(50).y;
    double worst_e = 0, worst_s = 0;
    for (const int sample : {0, 1}) {
        view::SegmentLayer segments;
        const view::ReceiverLayer layer = frame.receivers(sample, segments);
        const methods::LayerResult result = frame.irradiance(layer);
        const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
        ASSERT_EQ(segments.segments(), layer.pixels());
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            ASSERT_EQ(result.covered[i], 1);
            const glm::dvec3 origin(segments.origin[i]), direction(segments.direction[i]);
            for (int c = 0; c < 3; ++c) {
                const double e = sun[c] * cos_t * across(50) * std::exp(-extinction[c] / cos_t);
                worst_e = std::max(worst_e, std::abs(static_cast<double>(result.irradiance[i][c]) / e - 1));
                const double a = extinction[c] * (1 - direction.y / cos_t);
                const double s = scene.state.water->scattering[c] * 0.25 / glm::pi<double>() * sun[c] *
                                 across(50) * std::exp(extinction[c] * origin.y / cos_t) *
                                 -std::expm1(-a * segments.length[i]) / a;
                worst_s = std::max(worst_s, std::abs(static_cast<double>(radiance[i][c]) / s - 1));
            }
        }
    }
    printf("class: E off by %.1e, S by %.1e\n", worst_e, worst_s);
    // Floats; half a pixel beside its place S would be off by 5e-3.
    EXPECT_LT(worst_e, 2e-5);
    EXPECT_LT(worst_s, 1e-4);
}

TEST(AdaptiveBeamsClass, KeepsTheIrradianceThatItFoundWithScatteredLight) {
    scene::FrameScene scene = pool(50);
    scene.state.water->scattering = glm::dvec3(0.3);
    scene.state.clip.samples = 2;
    Frame frame(scene);
    view::SegmentLayer segments[2];
    const view::ReceiverLayer layers[2] = {frame.receivers(0, segments[0]), frame.receivers(1, segments[1])};
    std::vector<glm::vec3> alone[2];
    for (const int k : {0, 1}) alone[k] = frame.irradiance(layers[k]).irradiance;
    // At half resolution segments lack pixels, receivers do not.
    std::vector<std::uint8_t> every_second(layers[0].pixels());
    for (std::size_t i = 0; i < every_second.size(); ++i) every_second[i] = i % 2 == 0;
    const view::SegmentLayer half = render::segments_of(segments[1], every_second);
    const std::vector<glm::vec3> whole = frame.in_scatter(segments[1]);
    frame.method.expect(layers[0]);
    frame.in_scatter(segments[0]);
    frame.method.expect(layers[1]);
    const std::vector<glm::vec3> halved = frame.in_scatter(half);
    ASSERT_EQ(2 * halved.size(), whole.size());
    for (std::size_t i = 0; i < halved.size(); ++i) EXPECT_EQ(halved[i], whole[2 * i]);
    const double fragments = frame.stats.counted("beam fragments");
    EXPECT_GT(fragments, 0);
    for (const int k : {1, 0}) EXPECT_EQ(frame.irradiance(layers[k]).irradiance, alone[k]) << "sample " << k;
    EXPECT_EQ(frame.stats.counted("beam fragments"), fragments) << "drawn once more";
    // Kept once: what is asked for again is drawn again.
    EXPECT_EQ(frame.irradiance(layers[0]).irradiance, alone[0]);
    EXPECT_GT(frame.stats.counted("beam fragments"), fragments);
}

TEST(AdaptiveBeamsClass, CoversWhatTheCameraSeesDirectly) {
    const scene::FrameScene scene = pool(50);
    Frame frame(scene);
    view::SegmentLayer segments;
    view::ReceiverLayer layer = frame.receivers(0, segments);
    layer.flags[0] |= view::kBehindSpecular;
    layer.flags[1] |= view::kInGlass;
    layer.flags[2] = view::kEnvironment;
    const methods::LayerResult result = frame.irradiance(layer);
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        EXPECT_EQ(result.covered[i], i > 2) << i;
        EXPECT_EQ(result.irradiance[i].g > 0, i > 2) << i;
    }
    // Of a sun that has set there are no beams.
    const scene::FrameScene dark_scene = pool(-10);
    Frame dark(dark_scene);
    const methods::LayerResult none = dark.irradiance(layer);
    for (std::size_t i = 3; i < layer.pixels(); ++i) {
        EXPECT_EQ(none.covered[i], 1);
        EXPECT_EQ(none.irradiance[i], glm::vec3(0));
    }
}

TEST(AdaptiveBeamsClass, SaysWhatItLeavesOutAndWhatItNeeds) {
    scene::FrameState state = pool(50).state;
    state.water->scattering = glm::dvec3(0.1);
    const methods::AdaptiveBeams method;
    EXPECT_EQ(method.supports_surface(state).degree, methods::Support::Degree::partly);
    EXPECT_EQ(method.supports_volume(state).degree, methods::Support::Degree::partly);
    EXPECT_TRUE(method.supports_volume(state).in_air && method.supports_volume(state).in_water);
    // At least the texels of a view, and twice as many beams for twice the bodies.
    const std::size_t water = method.bytes(state, 0);
    EXPECT_GT(water, 4u * 8 * 8 * 48);
    state.objects.push_back(test::glass_ball({0, 1, 0}, 0.3, 1.5));
    EXPECT_GT(method.bytes(state, 0), 2 * water);
    EXPECT_GT(method.bytes(state, 1000), method.bytes(state, 0));
    const std::size_t clear = method.bytes(state, 0);
    state.media.emplace_back().type = scene::MediumType::grid;
    EXPECT_GE(method.bytes(state, 0), clear + methods::adaptive_beams::kLightColumnBytes);
}

TEST(Ends, OfBeamsOnAShelfLeaveTheFloorBelowItDark) {
    scene::FrameScene scene = pool(90);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene::Object shelf = test::floor_at(-0.97, 0.7);
    shelf.name = "shelf";
    scene.state.objects.push_back(shelf);
    scene.object_meshes.resize(2);
    // From below the shelf's edge along the floor.
    scene.state.camera.position = {-0.6, -0.985, 0};
    scene.state.camera.target = {0.2, -1, 0};
    Frame frame(scene);
    view::SegmentLayer segments;
    const view::ReceiverLayer layer = frame.receivers(0, segments);
    const methods::LayerResult result = frame.irradiance(layer);
    const double lit = scene.state.lights[0].irradiance.g * across(90);
    std::size_t dark_floor = 0, lit_floor = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        if (!(layer.flags[i] & view::kReceiver) || layer.object[i] != 0) continue;
        const glm::vec3 p = layer.position[i];
        if (std::max(std::abs(p.x), std::abs(p.z)) > 1.8f) continue;
        // All of the pixel's part of the floor.
        float innermost = 1, outermost = -1;
        for (const float u : {-0.5f, 0.5f})
            for (const float v : {-0.5f, 0.5f}) {
                const glm::vec3 corner = p + u * layer.footprint_u[i] + v * layer.footprint_v[i];
                const float beside = std::max(std::abs(corner.x), std::abs(corner.z)) - 0.35f;
                innermost = std::min(innermost, beside);
                outermost = std::max(outermost, beside);
            }
        const double e = result.irradiance[i].g;
        if (outermost < -1e-3f) {
            ++dark_floor;
            EXPECT_EQ(e, 0) << p.x << ' ' << p.z;
        } else if (innermost > 1e-3f) {
            ++lit_floor;
            EXPECT_NEAR(e, lit, 1e-4 * lit) << p.x << ' ' << p.z;
        }
    }
    EXPECT_GT(dark_floor, 50u);
    EXPECT_GT(lit_floor, 50u);
}

TEST(Ends, OfBeamsThatStraddleAnEdgeLightBothFaces) {
    scene::FrameScene scene = pool(45);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene::Object box;
    box.name = "box";
    box.shape = scene::Shape::box;
    box.size = {0.5, 0.6, 0.6};
    box.transform.position = {0, -0.7, 0};
    box.transform.rotation = {0, 0.4, 0};
    scene.state.objects.push_back(box);
    scene.object_meshes.resize(2);
    const glm::dvec3 sun = direction_in_water(45);
    // From the sun's side, from above, and from behind.
    std::size_t lit = 0, dark = 0;
    for (const glm::dvec3 from :
         {glm::dvec3(1.2, -0.2, 0.5), glm::dvec3(0.1, -0.05, 0), glm::dvec3(-1.2, -0.3, -0.4)}) {
        scene.state.camera.position = from;
        scene.state.camera.target = {0, -0.6, 0};
        Frame frame(scene);
        view::SegmentLayer segments;
        const view::ReceiverLayer layer = frame.receivers(0, segments);
        const methods::LayerResult result = frame.irradiance(layer);
        for (std::size_t i = 0; i < layer.pixels(); ++i) {
            if (!(layer.flags[i] & view::kReceiver) || layer.object[i] != 1) continue;
            const double facing = -glm::dot(sun, glm::dvec3(layer.geometric_normal[i]));
            const double e = scene.state.lights[0].irradiance.g * across(45) * std::max(0.0, facing);
            ++(facing > 0 ? lit : dark);
            const glm::vec3 p = layer.position[i];
            EXPECT_NEAR(result.irradiance[i].g, e, 1e-4) << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
    EXPECT_GT(lit, 500u);
    EXPECT_GT(dark, 100u);
}

TEST(Faces, ThatFaceAwayAreDarkWhateverTheirShadingNormals) {
    const scene::FrameScene scene = pool(50);
    Frame frame(scene);
    view::SegmentLayer segments;
    view::ReceiverLayer layer = frame.receivers(0, segments);
    layer.geometric_normal[7] = {0, -1, 0};
    layer.shading_normal[8] = {0, -1, 0};
    const methods::LayerResult result = frame.irradiance(layer);
    EXPECT_GT(result.irradiance[6].g, 0);
    EXPECT_EQ(result.irradiance[7].g, 0);
    EXPECT_EQ(result.irradiance[8].g, 0);
}

}  // namespace
}  // namespace dapple
