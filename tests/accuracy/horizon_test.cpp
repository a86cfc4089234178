// A sea of 10 km by the methods that start from a caustic map, seen from under the water: six cascades about
// the camera, against sliced_beams, which takes every triangle of the same rings of water.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "gpu/validated_device.h"
#include "image/image.h"
#include "render/frame_renderer.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple {
namespace {

image::Image picture(const std::string& caustics) {
    const auto timeline = timeline::Timeline::load(
        DAPPLE_SOURCE_DIR "/sequences/horizon.yaml",
        {"clip.resolution=[96, 54]", "clip.samples=1", "camera.position=[0.3 m, -1.5 m, 2.5 m]",
         "camera.target=[0 m, -3.5 m, -6 m]", "caustics={" + caustics + "}"});
    FrameStats stats;
    return render::FrameRenderer(test::validated_device()).render(timeline.at(24), stats).linear;
}

/// Of E, green, where the camera sees receivers directly: these methods cover no others.
double relative_l1(const image::Image& a, const image::Image& truth) {
    const std::vector<float>&e = a.find("E.G")->values, &expected = truth.find("E.G")->values,
          &covered = a.find("covered")->values;
    double apart = 0, sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (covered[i] == 0) continue;
        apart += std::abs(static_cast<double>(e[i]) - static_cast<double>(expected[i]));
        sum += static_cast<double>(expected[i]);
        ++count;
    }
    EXPECT_GT(count, expected.size() / 3);
    return apart / sum;
}

TEST(Horizon, TenKilometresOfSeaByCascadesFromBelow) {
    const image::Image truth = picture("method: sliced_beams, path_counts: false");
    const auto error = [&](const std::string& method, int resolution) {
        const double l1 = relative_l1(
            picture("method: " + method +
                    ", cascades: 6, cascade_scale: 4, map_resolution: " + std::to_string(resolution)),
            truth);
        printf("%s, six cascades of %d: L1 of E %.2f %%\n", method.c_str(), resolution, 100 * l1);
        return l1;
    };
    // Over the innermost 10 m photons lie 6 and 3 cm apart, which bends of waves of 1 m and longer tell, over
    // 5 m of depth: between first and second order.
    const double coarse = error("caustic_mesh", 160), fine = error("caustic_mesh", 320);
    EXPECT_LT(fine, 0.03);
    EXPECT_LT(fine, 0.7 * coarse);
    // One sample a pixel of 6 cm and more: splats are widened by it, whatever the map.
    EXPECT_LT(error("photon_splatting", 320), 0.1);
}

}  // namespace
}  // namespace dapple
