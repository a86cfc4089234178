// What Kougianos and Moustakas 2021 claim of their filter (section 4, figures 12 and 13), on the pool by
// points of too few photons, against sliced_beams: one adaptive pass is as good as ten of fixed radius, and
// takes a fifth of the time.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gpu/validated_device.h"
#include "render/frame_renderer.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple {
namespace {

struct Rendered {
    image::Image image;
    FrameStats stats;
};

Rendered pool(const std::string& caustics) {
    render::FrameRenderer renderer(test::validated_device());
    Rendered rendered;
    rendered.image =
        renderer
            .render(timeline::Timeline::load(std::string(DAPPLE_SOURCE_DIR) + "/sequences/pool.yaml",
                                             {"clip.samples=1", "clip.resolution=[240, 135]",
                                              "water.mesh_cells=400", "caustics={" + caustics + "}"})
                        .at(24),
                    rendered.stats)
            .linear;
    return rendered;
}

/// Sum of |difference| of E's green over the sum, where both cover.
double error(const Rendered& found, const Rendered& expected) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < found.image.pixels(); ++i) {
        if (!(found.image.find("covered")->values[i] > 0)) continue;
        const float e = expected.image.find("E.G")->values[i];
        difference += static_cast<double>(std::abs(found.image.find("E.G")->values[i] - e));
        sum += static_cast<double>(e);
    }
    return difference / sum;
}

double power_change(const Rendered& found) {
    return found.stats.counted("power after denoising, W") /
               found.stats.counted("power before denoising, W") -
           1;
}

double milliseconds(const Rendered& found) {
    double sum = 0;
    for (const PassTime& time : found.stats.passes())
        if (time.name == "denoise") sum += 1e3 * time.cpu_s;
    return sum;
}

TEST(Denoise, OneAdaptivePassAgainstTenFixedOnes) {
    const Rendered expected = pool("method: sliced_beams, path_counts: false");
    const auto splats = [](const std::string& denoise) {
        return pool("method: photon_splatting, map_resolution: 128, footprint: point, denoise: {" + denoise +
                    "}");
    };
    const Rendered fixed = splats("filter: fixed, passes: 10"), adaptive = splats("filter: adaptive");
    const Rendered paper_fixed = splats("filter: fixed, passes: 10, paper_faithful: true"),
                   paper_adaptive = splats("filter: adaptive, paper_faithful: true");
    const double ratio = error(adaptive, expected) / error(fixed, expected);
    const double paper_ratio = error(paper_adaptive, expected) / error(paper_fixed, expected);
    RecordProperty("error_of_one_adaptive_over_ten_fixed", std::to_string(ratio));
    RecordProperty("error_of_one_adaptive_over_ten_fixed_as_printed", std::to_string(paper_ratio));
    // By default the claim holds within 14 % (L1 of 0.31 and 0.27, of 1.36 unfiltered).
    EXPECT_LT(ratio, 1.25);
    EXPECT_LT(error(adaptive, expected), 0.35);
    // As printed it fails by 1.6 (1.18 and 0.72): steps of 5 pixels leave gaps, and light is made.
    EXPECT_GT(paper_ratio, 1.4);
    EXPECT_NEAR(power_change(adaptive), 0, 1e-5);
    EXPECT_GT(power_change(paper_adaptive), 0.04);
    // A quarter of the time; half, on a machine that is busy.
    EXPECT_LT(milliseconds(adaptive), 0.5 * milliseconds(fixed));
}

}  // namespace
}  // namespace dapple
