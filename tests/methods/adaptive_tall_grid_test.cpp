// adaptive_beams among grids that are many voxels tall, of which a thin layer matters.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/make_beams.h"
#include "methods/adaptive_frame.h"
#include "methods/adaptive_media.h"

namespace dapple {
namespace {

using namespace test::adaptive_frame;

constexpr int kTall = 480;  ///< voxels, of 5 cm

/// A cloud of six layers of voxels, 1 m below flat water; and far below it, if at all, one layer of next to
/// nothing, which makes the grid so many voxels tall.
scene::FrameScene cloud(bool with_faint_layer, bool from_above) {
    scene::FrameScene scene = pool(88);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.objects = {test::floor_at(-30, 100)};
    scene.state.media = {medium(scene::MediumType::grid)};
    scene.state.media[0].side = scene::MediumSide::water;
    scene.state.media[0].extinction = glm::dvec3(4);
    const int first = with_faint_layer ? -20 - kTall : -26;
    scene.medium_grids = {grid_of({-15, first, -15}, {31, -19 - first, 31}, 0.05, [&](glm::ivec3 at) {
        return at.y >= -26 ? 1 : at.y == first ? 1e-5 : 0;
    })};
    scene.state.camera.position = from_above ? glm::dvec3(-0.3, -0.5, 0.1) : glm::dvec3(-1.5, -1, 0.1);
    scene.state.camera.target = from_above ? glm::dvec3(-0.29, -1.2, 0.09) : glm::dvec3(-0.2, -1.2, 0);
    scene.state.camera.field_of_view = 8 * scene::kDegree;
    return scene;
}

std::vector<glm::vec3> in_scatter(const scene::FrameScene& scene) {
    Frame frame(scene);
    view::SegmentLayer segments;
    frame.receivers(0, segments);
    const std::vector<glm::vec3> radiance = frame.in_scatter(segments);
    std::vector<glm::vec3> primary;
    for (std::size_t i = 0; i < segments.segments(); ++i)
        if (segments.primary[i]) primary.push_back(radiance[i]);
    return primary;
}

TEST(TallGrid, HasTheLightThatItHasWithoutAFaintLayerFarBelow) {
    // From beside the cloud, where only the columns along light are so long; and down across all of the grid.
    for (const bool from_above : {false, true}) {
        const std::vector<glm::vec3> tall = in_scatter(cloud(true, from_above)),
                                     low = in_scatter(cloud(false, from_above));
        ASSERT_EQ(tall.size(), low.size());
        double sum = 0, off = 0, bias = 0;
        for (std::size_t i = 0; i < tall.size(); ++i) {
            const double change = static_cast<double>(tall[i].g) - static_cast<double>(low[i].g);
            sum += static_cast<double>(low[i].g);
            bias += change;
            off += std::abs(change);
        }
        printf("a grid %d voxels tall, seen from %s: S off by %.1e, its mean by %.1e\n", kTall,
               from_above ? "above" : "beside", off / sum, bias / sum);
        EXPECT_GT(sum, 0);
        // Places are a voxel apart in the tall grid and a tenth of one in the low one: where density grows
        // over a voxel, columns between places are off by an eighth of it at most, an optical depth of 0.025,
        // at two of the cloud's seven voxels; with either sign.
        EXPECT_LT(off / sum, 0.003);
        EXPECT_LT(std::abs(bias / sum), 0.001);
    }
}

TEST(TallGrid, CountsBeamsForWhichThereIsNoRoom) {
    // Beams of 25 cm want rays 10 cm apart.
    scene::FrameScene scene = cloud(true, true);
    scene.state.caustics.adaptive_beams.grid = 32;
    const rays::RayScene rays(scene);
    FrameStats stats;
    gpu::Device& device = test::validated_device();
    methods::FrameContext context{scene, rays, device, stats, {{0, light::Event::transmission}}};
    const std::vector<methods::adaptive_beams::BeamSet> sets = methods::adaptive_beams::make_beams(context);
    const auto thinned = [&](std::uint64_t largest_buffer) {
        FrameStats counts;
        methods::adaptive_beams::BeamRenderer renderer(device, largest_buffer);
        renderer.begin(scene, sets, methods::adaptive_beams::VolumeKind::six_triangles,
                       methods::adaptive_beams::Shading::exact, counts);
        return counts.counted("beams with thinned columns");
    };
    EXPECT_EQ(thinned(std::uint64_t{1} << 30), 0);
    // Some hundred beams meet the cloud, with ten rays or more of 482 places, 2 MB in all.
    EXPECT_GT(thinned(200000), 50);
}

}  // namespace
}  // namespace dapple
