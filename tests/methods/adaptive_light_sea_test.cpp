// Beams of wide seas: far off and out of sight they are merged, and still carry the light of the waves in
// them.
#include <gtest/gtest.h>

#include "adaptive_scene.h"
#include "gpu/validated_device.h"
#include "light/water_beams.h"
#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/make_beams.h"
#include "view/camera_paths.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr auto kT = light::Event::transmission;
constexpr auto kR = light::Event::reflection;

/// A sea of so many m along each side, of waves of 4 to 16 m, cells of its mesh 1 m; an eye 4 m deep.
scene::FrameScene sea(double side, double elevation) {
    scene::FrameScene scene;
    test::add_water(scene, 0.01, 2);
    scene::Water& water = *scene.state.water;
    for (scene::Wave& wave : water.surface.waves.waves) {
        wave.length *= 10;
        wave.amplitude *= 10;
        wave.wave_vector /= 10;
    }
    water.extent.size = {side, side};
    water.mesh_cells = static_cast<int>(side);
    water.absorption = {0.4, 0.5, 0.6};
    water.scattering = {0.3, 0.3, 0.3};
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    scene.state.lights = {test::sun_at(elevation)};
    scene.state.clip.width = 48;
    scene.state.clip.height = 27;
    scene.state.clip.samples = 1;
    scene.state.camera.position = {0, -4, 0};
    scene.state.camera.target = {3, -2, 0.5};
    scene.state.camera.field_of_view = 50 * scene::kDegree;
    return scene;
}

struct Seen {
    FrameStats stats;
    std::vector<BeamSet> sets;
    std::vector<glm::vec3> scattered;

    Seen(const scene::FrameScene& scene, std::vector<light::Chain> chains, bool drawn) {
        const rays::RayScene rays(scene);
        FrameContext context{scene, rays, test::validated_device(), stats, std::move(chains)};
        sets = make_beams(context);
        if (!drawn) return;
        view::LayerCounts counts;
        view::SegmentLayer segments;
        view::trace_layer(scene, rays, {}, counts, &segments);
        BeamRenderer renderer(test::validated_device());
        renderer.begin(scene, sets, VolumeKind::six_triangles, Shading::exact, stats);
        scattered = renderer.render(&segments, nullptr, stats).scattered;
    }
};

TEST(AdaptiveLightSea, AKilometreCostsLittleMoreThanAPatch) {
    scene::FrameScene patch = sea(32, 70), wide = sea(1024, 70);
    patch.state.caustics.adaptive_beams.levels = 3;
    // Cells as small as those of the patch: a thousandth of its 2 m by 2 m.
    wide.state.caustics.adaptive_beams.levels = 8;
    const Seen of_patch(patch, {{0, kT}}, true), of_wide(wide, {{0, kT}}, true);
    const double beams = of_wide.stats.counted("beams");
    printf("beams: patch %.0f, a kilometre %.0f; fragments %.2e, %.2e\n", of_patch.stats.counted("beams"),
           beams, of_patch.stats.counted("beam fragments"), of_wide.stats.counted("beam fragments"));
    EXPECT_LT(beams, 3 * of_patch.stats.counted("beams"));
    // 12 m and more away, where the patch ends, there is light of exp(-12 * 0.7 - ...) < 1e-4 left. Otherwise
    // both are as good as the tolerance.
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < of_patch.scattered.size(); ++i) {
        difference += std::abs(static_cast<double>(of_wide.scattered[i].r - of_patch.scattered[i].r));
        sum += static_cast<double>(of_patch.scattered[i].r);
    }
    printf("S differs by %.4f\n", difference / sum);
    EXPECT_LT(difference / sum, 0.02);
}

TEST(AdaptiveLightSea, MergedBeamsCarryTheLightOfTheirWaves) {
    // A low sun, by whose light the water's transmittance changes much from wave to wave; an eye that looks
    // away, so that no cell is split: 8 m wide, as the waves are.
    scene::FrameScene scene = sea(128, 25);
    // Shares are means of the corners' in the mesh; a quarter of a metre apart they are the waves'.
    scene.state.water->mesh_cells = 512;
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(*scene.state.water).mesh(0));
    scene.state.camera.position = {500, -4, 0};
    scene.state.camera.target = {600, -4, 0};
    scene.state.caustics.adaptive_beams.levels = 3;
    const Seen merged(scene, {{0, kT}, {0, kR}}, false);
    EXPECT_LT(merged.stats.counted("beams"), 2000);
    const rays::RayScene rays(scene);
    FrameStats stats;
    glm::dvec2 expected(0), found(0);  // W, by event; of what is mirrored little meets anything
    glm::dvec3 expected_way(0), found_way(0);
    for (const light::Event event : {kT, kR})
        for (const auto& sheet : light::water_beams<double>(scene, rays, {0, event}, 1, stats))
            for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
                const glm::uvec3 corner = scene.water->mesh.triangles[i];
                const double flux = sheet.flux[i] * test::mean(sheet.color);
                expected[static_cast<int>(event)] += flux;
                for (int k = 0; k < 3 && event == kT; ++k) {
                    const auto& ray = sheet.rays[corner[k]];
                    const glm::dvec3 way(ray.slope_a, ray.slope_b, 1);
                    expected_way += flux / 3 * glm::normalize(sheet.world_from_mesh * way);
                }
            }
    for (const BeamSet& set : merged.sets)
        for (std::size_t i = 0; i < set.triangles.size(); ++i) {
            const double flux = test::mean(glm::dvec3(set.flux[i]));
            found[set.in_water ? 0 : 1] += flux;
            for (int k = 0; k < 3 && set.in_water; ++k) {
                const BeamSet::Vertex& v = set.vertices[set.triangles[i][k]];
                found_way +=
                    flux / 3 * glm::normalize(set.world_from_mesh * glm::dvec3(v.slope_a, v.slope_b, 1));
            }
        }
    const double share = found.x / merged.stats.counted("light on specular surfaces, W");
    const double of_mesh = expected.x / (expected.x + expected.y);
    const double off = glm::length(found_way / found.x - expected_way / expected.x);
    printf("share that goes in %.5f, of the mesh %.5f; mean way off by %.1e rad\n", share, of_mesh, off);
    EXPECT_NEAR(share / of_mesh, 1, 1e-3);
    // What a mean normal refracts is the mean of what normals do but for the variance of slopes, 0.02.
    EXPECT_LT(off, 0.012);
}

}  // namespace
}  // namespace dapple::methods::adaptive_beams
