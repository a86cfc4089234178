// Light that splats throw past the edge of what they landed on: a rail over the floor of a flat pool, under
// an overhead sun, seen from the side.
#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kRail = 0.32;    // m, its width; it lies along z
constexpr double kSpacing = 0.1;  // m: of photons at 5 and 15 cm from the middle, whose cells end at 20 cm
constexpr double kOverhang = 0.2 - 0.5 * kRail;

struct Leak {
    double share;      // of the rail's light, on the floor on top of what belongs there
    double brightest;  // floor
    double shadow;     // brightest floor well inside the rail's
    double rail;       // mean E of its top, of what belongs there
};

Leak leak(scene::PhotonFootprint footprint, bool paper) {
    scene::FrameState state = test::pool_over_floor(6, 1.5, 1, 480);
    state.clip.height = 24;
    state.camera.view_height = 1.2 * 24 / 480;  // 1.2 m along x, all of it under water
    state.camera.position = {0.6, -0.6, 0};
    state.camera.target = {0, -1.2, 0};
    state.water->absorption = glm::dvec3(0);
    state.lights = {test::sun_from_zenith(0)};
    scene::Object rail;
    rail.name = "rail";
    rail.shape = scene::Shape::box;
    rail.size = {kRail, 0.1, 4};
    rail.transform.position = {0, -1.05, 0};
    state.objects.push_back(rail);
    state.caustics.method = "photon_splatting";
    state.caustics.map.map_resolution = static_cast<int>(6 / kSpacing);
    state.caustics.map.cascade_center = scene::CascadeCenter::extent;
    state.caustics.map.paper_faithful = paper;
    state.caustics.photon_splatting.footprint = footprint;
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    const render::RenderedFrame frame = renderer.render(state, stats);
    const std::vector<float>& e = frame.linear.find("E.R")->values;
    const std::vector<float>& x = frame.linear.find("P.X")->values;
    const std::vector<float>& height = frame.linear.find("P.Y")->values;
    const double expected = state.lights[0].irradiance.r * test::flat_floor(0, 1.5, 1.333).irradiance;
    double excess = 0, on_rail = 0, brightest = 0, shadow = 0;
    std::size_t rail_pixels = 0;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const double ratio = static_cast<double>(e[i]) / expected;
        if (height[i] < -1.49f) {
            excess += std::max(0.0, ratio - 1);
            brightest = std::max(brightest, ratio);
            // A photon beside it, 25 cm from its middle, lights at most one spacing inwards.
            if (std::abs(x[i]) < 0.14f) shadow = std::max(shadow, ratio);
        } else if (std::abs(height[i] + 1) < 1e-3f) {
            on_rail += ratio;
            ++rail_pixels;
        }
    }
    EXPECT_GT(rail_pixels, 500u);
    return {excess / on_rail, brightest, shadow, on_rail / static_cast<double>(rail_pixels)};
}

TEST(Leak, PaperSplatsLightWhatLiesBehindTheOverhangAndOursDoNot) {
    using Name = scene::PhotonFootprint;
    for (const Name footprint : {Name::tent, Name::photon_differential, Name::photon_difference}) {
        const Leak ours = leak(footprint, false);
        EXPECT_LT(ours.brightest, 1.001);  // as flat as flat water is
        EXPECT_EQ(ours.shadow, 0);
        EXPECT_NEAR(ours.rail, 1, 1e-3);
    }
    const Leak paper = leak(Name::photon_difference, true);
    printf("of the light on the rail %.1f %% leaks, by the overhang %.1f %%\n", 100 * paper.share,
           100 * kOverhang / kRail);
    EXPECT_NEAR(paper.brightest, 2, 0.01);
    // The camera looks past one edge; behind the other's overhang it sees the rail's side, which the light
    // passes. Pixels are 3.5 mm on level ground.
    EXPECT_NEAR(paper.share, kOverhang / kRail, 0.0036 / kRail);
    EXPECT_NEAR(paper.rail, 1, 1e-3);
}

}  // namespace
}  // namespace dapple
