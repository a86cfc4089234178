// Photons under one sinusoid (closed_form/sinusoid.h).
#include "closed_form/sinusoid.h"

#include <gtest/gtest.h>

#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

double relative_l1_error(double depth, int resolution, int samples = 1) {
    constexpr int kPixels = 200;
    scene::FrameState state = test::sinusoid_pool(depth, kPixels, 16);
    state.caustics.method = "photon_splatting";
    state.caustics.map.map_resolution = resolution;
    state.clip.samples = samples;
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    const render::RenderedFrame frame = renderer.render(state, stats);
    return test::sinusoid_error(frame.linear.find("E.R")->values, depth, kPixels);
}

class Sinusoid : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(DepthOverFocus, Sinusoid, testing::Values(0.5, 2.0),
                         [](const auto& depth) { return depth.param < 1 ? "before" : "behind"; });

TEST_P(Sinusoid, ErrorFallsUntilTheKernelIsAPixelWide) {
    // Photons 11.7, 5.9, 2.9 and 1.5 mm apart on the water, pixels of 5 mm.
    double errors[4];
    for (int level = 0; level < 4; ++level) {
        errors[level] = relative_l1_error(GetParam() * test::kSinusoidFocus, 256 << level);
        RecordProperty("relative_l1_" + std::to_string(256 << level), std::to_string(errors[level]));
        printf("depth %.1f D*, %4d photons across: relative L1 error %.4f\n", GetParam(), 256 << level,
               errors[level]);
    }
    EXPECT_LT(errors[1], errors[0]);
    EXPECT_LT(errors[2], errors[1]);
    // From here on the kernel is a pixel wide whatever the photons: more of them change nothing for the
    // worse.
    EXPECT_LT(errors[3], 1.05 * errors[2]);
    // Measured 0.0003 and 0.0015. Before the focus E is smooth, so that little but the kernel's blur is left;
    // behind it there are folds, whose peaks the kernel spreads over its width.
    EXPECT_LT(errors[2], GetParam() < 1 ? 0.001 : 0.003);
}

TEST_P(Sinusoid, SamplesOfAPixelAreMeansOverTheirPartsOfIt) {
    // Photons 1.5 mm apart, cells of pixels of 5, 2.5 and 1.25 mm: whatever a kernel holds, its mean over the
    // cells is that over the pixel.
    const double depth = GetParam() * test::kSinusoidFocus;
    for (const int samples : {1, 4, 16}) {
        const double error = relative_l1_error(depth, 2048, samples);
        printf("depth %.1f D*, %2d samples: relative L1 error %.5f\n", GetParam(), samples, error);
        // Measured 0.0002 and 0.0006. A whole pixel's box at each of several samples would spread the folds
        // over two pixels: 0.06.
        EXPECT_LT(error, GetParam() < 1 ? 0.0003 : 0.001) << samples;
    }
}

}  // namespace
}  // namespace dapple
