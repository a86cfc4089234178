// Columns of bounded media along the light's rays below flat water, against the media's own exact integrals.
#include <gtest/gtest.h>

#include <string>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "media/media.h"

namespace dapple {
namespace {

constexpr double kVoxel = 0.1, kTop = -0.5;

/// Flat water under the sun at the zenith.
scene::FrameScene pool() {
    scene::FrameScene scene = test::scene_of_flat_water({1.8, 1.8}, 6, 6);
    scene.state.lights = {test::sun_from_zenith(0)};
    return scene;
}

/// Voxels whose density depends on their height alone: `density(m below the top)`.
template <class Density>
scene::FrameScene layers(int voxels, double extinction, Density&& density) {
    constexpr int n = 21;
    std::vector<float> values;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < voxels; ++y)
            for (int x = 0; x < n; ++x)
                values.push_back(static_cast<float>(density(kVoxel * (voxels - 1 - y))));
    scene::FrameScene scene = pool();
    scene::Medium& cloud = scene.state.media.emplace_back();
    cloud.type = scene::MediumType::grid;
    cloud.side = scene::MediumSide::water;
    cloud.extinction = extinction * glm::dvec3(0.5, 0.8, 1);
    cloud.transform.position = {0, kTop - kVoxel * (voxels - 1), 0};
    scene.medium_grids = {grids::DensityGrid::from_values({-n / 2, 0, -n / 2}, {n, voxels, n}, values,
                                                          glm::dmat4(glm::dmat3(kVoxel)))};
    return scene;
}

void add_box(scene::FrameScene& scene, double centre, double height) {
    scene::Medium& box = scene.state.media.emplace_back();
    box.type = scene::MediumType::box;
    box.side = scene::MediumSide::water;
    box.size = {6, height, 6};
    box.transform.position = {0, centre, 0};
    box.extinction = {1, 2, 4};
    scene.medium_grids.resize(scene.state.media.size());
}

/// Largest error of the optical depth of all bounded media along the rays, in any channel.
double worst_off(const scene::FrameScene& scene, double deepest, std::size_t& coarse) {
    const test::SheetSet<float> set(scene, light::Event::transmission, deepest);
    const methods::sliced_beams::RayColumns<float>& columns = set.sheets().front()->columns();
    const media::Media media(scene);
    coarse = columns.coarse_rays();
    double worst = 0;
    for (double depth = 0.013; depth < deepest; depth += 0.017) {
        glm::dvec3 expected = media.optical_depth({0.1, 0, 0.1}, {0, -1, 0}, depth, true);
        expected -= depth * media.components()[0].extinction;
        if (std::min({expected.x, expected.y, expected.z}) > 60) break;  // no light is left
        for (const std::size_t beam : {std::size_t{30}, std::size_t{41}}) {
            const glm::dvec3 found = columns.optical_depth(beam, {0.5, 0.3, 0.2}, depth);
            for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(found[c] - expected[c]));
        }
    }
    return worst;
}

/// Points are as fine as needed to be off by 0.005 and a tenth of that at either end, however tall the grid
/// and wherever in it the cloud; where they cannot be, the ray is asked itself. In float columns are exact to
/// 1e-6 of them.
TEST(RayColumns, FollowTallGridsToATolerance) {
    const auto thin_cloud = [](double below) { return below < 0.55 ? 1.0 : 0.0; };
    const auto faint = [&](double below) { return thin_cloud(below) + (below > 60.55 ? 1e-3 : 0.0); };
    const auto two = [&](double below) { return thin_cloud(below) + (below > 60.05 ? 1.0 : 0.0); };
    const auto many = [](double below) { return 0.5 + 0.5 * std::sin(9 * below); };
    struct Case {
        std::string name;
        scene::FrameScene scene;
        bool coarse;
    };
    for (const auto& [name, scene, coarse] :
         {Case{"a thin cloud alone", layers(607, 4, thin_cloud), false},
          Case{"with a faint layer far below", layers(607, 4, faint), false},
          Case{"with a thin cloud far below", layers(607, 0.5, two), false},
          Case{"with a dense cloud far below", layers(607, 4, two), true},
          Case{"layer after layer", layers(607, 0.5, many), false},
          Case{"dense layer after layer", layers(607, 4, many), true}}) {
        std::size_t rays = 0;
        const double worst = worst_off(scene, 62, rays);
        printf("%s: optical depth off by %.1e, %zu coarse rays\n", name.c_str(), worst, rays);
        EXPECT_LT(worst, 0.006) << name;
        EXPECT_EQ(rays > 0, coarse) << name;
    }
}

/// A medium's points lie where it is, whatever others there are on the ray.
TEST(RayColumns, KeepMediaApart) {
    scene::FrameScene scene = pool();
    add_box(scene, -1.25, 0.5);
    std::size_t coarse = 0;
    EXPECT_LT(worst_off(scene, 3, coarse), 2e-5);
    add_box(scene, -40, 0.5);
    add_box(scene, -300, 20);
    EXPECT_LT(worst_off(scene, 3, coarse), 2e-5);
    EXPECT_LT(worst_off(scene, 330, coarse), 2e-3);  // floats of 1e-5 m, of 4 /m, and a column of 80
    EXPECT_EQ(coarse, 0);
}

}  // namespace
}  // namespace dapple
