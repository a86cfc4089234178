// Photons of cascades on receivers: no light twice or missing where their boxes end.
#include <gtest/gtest.h>

#include "methods/splat_scene.h"

namespace dapple {
namespace {

using Name = scene::PhotonFootprint;
constexpr Name kFootprints[] = {Name::tent, Name::fixed, Name::photon_differential, Name::photon_difference};

scene::FrameScene cascaded_pool(double zenith, int resolution, int cascades, double scale) {
    scene::FrameScene scene = test::flat_pool(zenith, resolution);
    scene.state.caustics.map.cascades = cascades;
    scene.state.caustics.map.cascade_scale = scale;
    return scene;
}

std::vector<double> green(const methods::LayerResult& result) {
    std::vector<double> values;
    for (const glm::vec3& e : result.irradiance) values.push_back(static_cast<double>(e.g));
    return values;
}

/// Largest relative difference.
double farthest(const std::vector<double>& a, const std::vector<double>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] / b[i] - 1));
    return worst;
}

double farthest_from_flat(const scene::FrameScene& scene, double zenith) {
    const std::vector<double> e = green(test::splat_level(scene, -1.5));
    return farthest(e, std::vector<double>(e.size(), test::flat_floor(scene, zenith).g));
}

TEST(CascadeSplats, FlatWaterComesOutFlatAcrossTheirBorders) {
    struct Case {
        int cascades;
        double scale;
    };
    // 3.6 m of 6 m are seen: all borders but the outermost, which a slanting sun throws 0.9 m away.
    for (const auto [cascades, scale] : {Case{2, 2}, Case{4, 2}, Case{3, 2.5}, Case{3, 3}})
        for (const double zenith : {0.0, 50.0})
            for (const Name footprint : kFootprints) {
                SCOPED_TRACE(testing::Message() << cascades << ", s " << scale << ", zenith " << zenith
                                                << ", footprint " << int(footprint));
                scene::FrameScene scene = cascaded_pool(zenith, 200, cascades, scale);
                scene.state.caustics.photon_splatting.footprint = footprint;
                test::look_down(scene, 96, 3.6);
                scene.state.camera.position.x = scene.state.camera.target.x = 0.123;
                // As without cascades: positions in float, against spacings down to a thousandth of 6 m.
                EXPECT_LT(farthest_from_flat(scene, zenith), 1e-4);
            }
}

// Where a pixel is about as wide as the finer spacing it widens the finer tents alone: up to a quarter of the
// shares' second differences shows, 1 / ramp^2.
TEST(CascadeSplats, BordersShowByLessThanAThousandthWhateverTheFootprints) {
    for (const Name footprint : kFootprints) {
        SCOPED_TRACE(static_cast<int>(footprint));
        scene::FrameScene scene = cascaded_pool(0, 128, 3, 2);
        scene.state.caustics.photon_splatting.footprint = footprint;
        test::look_down(scene, 96, 4);  // 4.2 cm a pixel, 4.7 cm between the outermost photons
        EXPECT_LT(farthest_from_flat(scene, 0), 1e-3);
    }
}

// Where the camera looks obliquely the shortest vectors of a lattice lie along other diagonals of its texels.
// Of tents on both lattices again second differences show. Boxes along such vectors do not tile the texels
// that have one share each: half of a step of the shares may show, of a ramp of 48 1/24 at most. Boxes along
// the texels
// ("fixed") have no such seam.
TEST(CascadeSplats, BordersOfBoxesAlongDiagonalsShowByAStepOfTheRampAtMost) {
    for (const Name footprint : kFootprints) {
        SCOPED_TRACE(static_cast<int>(footprint));
        scene::FrameScene scene = cascaded_pool(30, 512, 2, 2);
        scene.state.caustics.photon_splatting.footprint = footprint;
        test::look_down(scene, 96, 0.5);
        scene.state.caustics.map.cascade_center = scene::CascadeCenter::extent;
        scene.state.camera.target = {1.2, -1.5, 0.4};
        scene.state.camera.position = scene.state.camera.target + glm::dvec3(-1, 0.5, -0.8);
        scene.state.camera.up = {0, 1, 0};
        const double worst = farthest_from_flat(scene, 30);
        printf("footprint %d: %.1e\n", static_cast<int>(footprint), worst);
        EXPECT_LT(worst, footprint == Name::tent || footprint == Name::fixed ? 1e-3 : 0.5 / 24);
    }
}

TEST(CascadeSplats, ReachTenKilometres) {
    scene::FrameScene scene = test::water_scene({10000, 10000});
    scene.state.lights = {test::sun(40, 33)};
    scene.state.objects = {test::level(-1.5, 10000)};
    scene.state.caustics.map.map_resolution = 320;
    scene.state.caustics.map.cascades = 6;
    scene.state.caustics.map.cascade_scale = 4;  // 9.8 m about the camera, 3 cm apart
    scene.origin = {3012, 0, -1733};
    test::add_water(scene, {}, 100, 100);
    for (const double view : {40.0, 2000.0}) {
        test::look_down(scene, 64, view);
        for (glm::dvec3* point : {&scene.state.camera.position, &scene.state.camera.target})
            *point += glm::dvec3(3012.3, 0, -1733.4);
        // As any borders; ramps of 20 steps here. Floats are relative to the origin: at 1 km positions are
        // good to 6e-5 m, against 8 m between photons.
        EXPECT_LT(farthest_from_flat(scene, 40), 1e-3) << view;
    }
}

TEST(CascadeSplats, WavesThatTheCoarserMapResolvesShowNoBorder) {
    std::vector<test::Sinusoid> sea;
    for (const test::Sinusoid& s : test::gentle_sea(0.0008))
        if (glm::length(s.wave) < 9) sea.push_back(s);  // 0.7 m and longer
    const auto picture = [&](int resolution, int cascades, Name footprint = Name::tent) {
        scene::FrameScene scene = cascaded_pool(20, resolution, cascades, 2);
        scene.state.caustics.photon_splatting.footprint = footprint;
        test::add_water(scene, sea, 200, 200);
        test::look_down(scene, 96, 4);
        return green(test::splat_level(scene, -1.5));
    };
    const std::vector<double> fine = picture(512, 1);
    const auto [low, high] = std::minmax_element(fine.begin(), fine.end());
    EXPECT_GT(*high / *low, 1.15);  // there are waves
    const double coarse = farthest(picture(256, 1), fine), cascades = farthest(picture(256, 2), fine);
    // What the coarser map alone is off, in bends of E between its photons 2.3 cm apart.
    EXPECT_LT(coarse, 2e-3);
    EXPECT_LT(cascades, 1.1 * coarse);  // other places of photons, by a third of a step
    // Boxes leave seams of their own between photons, of one map too.
    for (const Name footprint : {Name::photon_differential, Name::photon_difference}) {
        const double one = farthest(picture(256, 1, footprint), fine),
                     two = farthest(picture(256, 2, footprint), fine);
        printf("footprint %d: %.2e, with two cascades %.2e\n", static_cast<int>(footprint), one, two);
        EXPECT_LT(two, 1.1 * one);
    }
}

TEST(CascadeSplats, OfALampAreAsOneMap) {
    const auto picture = [&](int resolution, int cascades) {
        scene::FrameScene scene = cascaded_pool(0, resolution, cascades, 2);
        scene::Light& lamp = scene.state.lights[0];
        lamp.type = scene::LightType::point;
        lamp.position = {0.4, 1.2, -0.3};
        test::look_down(scene, 96, 3);
        return green(test::splat_level(scene, -1.5));
    };
    // Both are within a thousandth of the closed form, which the tents' second differences make up.
    EXPECT_LT(farthest(picture(300, 3), picture(600, 1)), 2e-3);
}

}  // namespace
}  // namespace dapple
