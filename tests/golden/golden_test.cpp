// Small frames of the demo timelines against stored ones. They guard what no closed form sees (a seam, a
// missing object, a texture upside-down); they never stand alone for a figure. `tools/bless` writes them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "gpu/validated_device.h"
#include "image/exr.h"
#include "render/frame_renderer.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple {
namespace {

/// Most pixels this close, few worse, none wrong: relative to the frame's own scale (1 + value). Equal
/// drivers on different processors differ in the last digits of positions, which moves splats across pixel
/// edges.
struct Tolerance {
    double near = 2e-3;
    double share_not_near = 2e-3;
    double hard = 0.25;
};

struct Golden {
    const char* name;
    const char* timeline;
    std::int64_t frame;
    std::vector<std::string> settings = {"clip.samples=2", "water.mesh_cells=200"};
};

/// Adaptive beams cost by their fragments.
const std::vector<std::string> kFewFragments = {"clip.samples=1", "caustics.levels=1"};

const std::vector<std::string> kFewPhotons = {"clip.samples=1", "water.mesh_cells=400",
                                              "caustics.map_resolution=192"};

void PrintTo(const Golden& golden, std::ostream* stream) {
    *stream << golden.name;
}

class GoldenFrame : public testing::TestWithParam<Golden> {};
INSTANTIATE_TEST_SUITE_P(
    Demos, GoldenFrame,
    testing::Values(Golden{"pool", "pool.yaml", 20}, Golden{"poolside", "poolside.yaml", 20},
                    Golden{"deep", "deep.yaml", 20}, Golden{"seabed", "seabed.yaml", 10},
                    Golden{"bridge", "bridge.yaml", 5}, Golden{"blender_ocean", "blender_ocean.yaml", 3},
                    Golden{"godrays", "godrays.yaml", 20}, Golden{"smoke", "smoke.yaml", 18},
                    Golden{"fog", "fog.yaml", 20, {"clip.samples=1", "water.mesh_cells=120"}},
                    Golden{"glass_sphere", "glass_sphere.yaml", 20, kFewFragments},
                    Golden{"glass_mesh", "glass_mesh.yaml", 20, kFewFragments},
                    Golden{"town_above", "town.yaml", 10, kFewPhotons},
                    Golden{"town_below", "town.yaml", 45, kFewPhotons},
                    Golden{"horizon", "horizon.yaml", 24, {"clip.samples=1", "water.rings.cells=64"}},
                    Golden{"adaptive_godrays",
                           "godrays.yaml",
                           20,
                           {"clip.samples=1", "water.mesh_cells=120",
                            "caustics={method: adaptive_beams, levels: 1, volume_resolution: half}"}}),
    [](const auto& golden) { return golden.param.name; });

image::Image render_small(const Golden& golden) {
    std::vector<std::string> settings{"clip.resolution=[128, 72]"};
    settings.insert(settings.end(), golden.settings.begin(), golden.settings.end());
    const timeline::Timeline timeline =
        timeline::Timeline::load(std::string(DAPPLE_SOURCE_DIR "/sequences/") + golden.timeline, settings);
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    image::Image linear = renderer.render(timeline.at(golden.frame), stats).linear;
    image::Image beauty;
    beauty.width = linear.width;
    beauty.height = linear.height;
    for (const char* name : {"R", "G", "B"}) beauty.channels.push_back(*linear.find(name));
    beauty.metadata = {{"dapple:driver", test::validated_device().info().driver}};
    return beauty;
}

TEST_P(GoldenFrame, IsAsStored) {
    const std::string path =
        std::string(DAPPLE_SOURCE_DIR "/tests/golden/frames/") + GetParam().name + ".exr";
    const image::Image rendered = render_small(GetParam());
    if (std::getenv("DAPPLE_BLESS")) {
        std::filesystem::create_directories(std::filesystem::path(path).parent_path());
        image::write_exr_verified(path, rendered, {});
        return;
    }
    const image::Image stored = image::read_exr(path);
    if (stored.metadata != rendered.metadata) {
        GTEST_SKIP() << "stored with another driver (" << stored.metadata[0].second << "); this one is "
                     << rendered.metadata[0].second;
    }
    const Tolerance tolerance;
    ASSERT_EQ(stored.width, rendered.width);
    ASSERT_EQ(stored.height, rendered.height);
    std::size_t not_near = 0;
    double largest = 0;
    for (const image::Channel& channel : rendered.channels) {
        const image::Channel* expected = stored.find(channel.name);
        ASSERT_NE(expected, nullptr) << channel.name;
        for (std::size_t i = 0; i < channel.values.size(); ++i) {
            const double difference =
                std::abs(channel.values[i] - expected->values[i]) / (1 + std::abs(expected->values[i]));
            not_near += difference > tolerance.near;
            largest = std::max(largest, difference);
        }
    }
    EXPECT_LE(static_cast<double>(not_near),
              tolerance.share_not_near * 3 * static_cast<double>(rendered.pixels()));
    EXPECT_LE(largest, tolerance.hard);
}

}  // namespace
}  // namespace dapple
