// The clips of glass, small, by adaptive beams against the reference: E, and S where every pixel is served.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "gpu/validated_device.h"
#include "render/frame_renderer.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple {
namespace {

constexpr int kWidth = 96, kHeight = 54;

struct Frame {
    image::Image linear;
    FrameStats stats;
    /// A value a pixel, green.
    const std::vector<float>& operator[](const std::string& layer) const {
        const image::Channel* channel = linear.find(layer + ".G");
        if (!channel) throw std::runtime_error("no layer " + layer);
        return channel->values;
    }
    /// Light that the stats name as lost for that glass mirrors it within, over what meets the glass.
    double mirrored_within() const {
        return (stats.counted("lost to total reflection, W") +
                stats.counted("lost to reflection inside glass, W") +
                stats.counted("lost to reflection at later surfaces, W")) /
               stats.counted("light on specular surfaces, W");
    }
};

Frame rendered(const std::string& clip, std::vector<std::string> settings) {
    settings.insert(settings.begin(), "clip.resolution=[96, 54]");
    const auto timeline = timeline::Timeline::load(DAPPLE_SOURCE_DIR "/sequences/" + clip, settings);
    render::FrameRenderer renderer(test::validated_device());
    Frame frame;
    frame.linear = renderer.render(timeline.at(24), frame.stats).linear;
    return frame;
}

Frame reference(const std::string& clip, std::vector<std::string> settings) {
    // One camera path stands for a pixel: the reference takes the mean over it by itself.
    settings.insert(settings.end(),
                    {"clip.samples=1", "caustics={method: reference, standard_error: 0.04, most_rays: 30}"});
    return rendered(clip, settings);
}

struct Errors {
    double l1 = 0, bias = 0;  ///< shares of the reference
    double noise = 0;         ///< of the reference: what L1 has at least
    double blocks = 0;        ///< L1 of means over blocks of 6 x 6 pixels
};

/// Of E over the pixels that both cover.
Errors errors_of(const char* what, const Frame& ours, const Frame& truth, const std::string& layer,
                 const std::string& variance) {
    constexpr int kBlock = 6;
    Errors errors;
    double sum = 0, block_sum = 0;
    const std::vector<float>&a = ours[layer], &b = truth[layer], &noise = truth[variance];
    const std::vector<float>& a_covered = ours.linear.find("covered")->values;
    const std::vector<float>& b_covered = truth.linear.find("covered")->values;
    for (int y = 0; y < kHeight; y += kBlock) {
        for (int x = 0; x < kWidth; x += kBlock) {
            double difference = 0;
            for (int k = 0; k < kBlock * kBlock; ++k) {
                const auto i = static_cast<std::size_t>((y + k / kBlock) * kWidth + x + k % kBlock);
                if (layer == "E" && (a_covered[i] < 1 || b_covered[i] < 1)) continue;
                const double off = static_cast<double>(a[i]) - static_cast<double>(b[i]);
                sum += static_cast<double>(b[i]);
                errors.bias += off;
                errors.l1 += std::abs(off);
                errors.noise += std::sqrt(2 / std::numbers::pi * static_cast<double>(noise[i]));
                difference += off;
            }
            block_sum += std::abs(difference);
        }
    }
    EXPECT_GT(sum, 0);
    errors = {errors.l1 / sum, errors.bias / sum, errors.noise / sum, block_sum / sum};
    printf("%s: L1 %.4f, of blocks %.4f, bias %+.4f, the reference's noise %.4f; mirrored within %.3f\n",
           what, errors.l1, errors.blocks, errors.bias, errors.noise, ours.mirrored_within());
    return errors;
}

TEST(GlassClips, TheBallsConeInTheWaterAndItsRingOnTheFloor) {
    // Down, where the camera meets no surface of the water, behind which the method finds no light.
    const std::vector<std::string> view = {"camera.target=[0.3 m, -1.8 m, 0.05 m]",
                                           "camera.field_of_view=44 deg"};
    std::vector<std::string> settings = view;
    settings.insert(settings.end(), {"clip.samples=9", "caustics.volume_resolution=full"});
    const Frame ours = rendered("glass_sphere.yaml", settings);
    const Frame truth = reference("glass_sphere.yaml", view);
    const Errors s = errors_of("ball, S", ours, truth, "volume_caustics", "S.variance");
    EXPECT_LT(s.l1, 1.3 * s.noise);
    EXPECT_LT(std::abs(s.bias), 0.01);
    const Errors e = errors_of("ball, E", ours, truth, "E", "E.variance");
    // Nine points tell the mean over a pixel of the ring to some hundredths.
    EXPECT_LT(e.l1, 0.02 + e.noise);
    EXPECT_LT(e.blocks, 0.02);
    EXPECT_LT(std::abs(e.bias), 0.01);
}

TEST(GlassClips, TheCutGlassOnTheFloor) {
    const Frame truth = reference("glass_mesh.yaml", {});
    double before = 1;
    for (const int levels : {0, 2, 4}) {
        const Frame ours =
            rendered("glass_mesh.yaml", {"clip.samples=4", "caustics.levels=" + std::to_string(levels)});
        const std::string what = "cut glass, " + std::to_string(levels) + " levels, E";
        const Errors e = errors_of(what.c_str(), ours, truth, "E", "E.variance");
        EXPECT_LT(e.blocks, 0.75 * before);
        before = e.blocks;
        // What the glass mirrors within is missing, and named.
        EXPECT_LT(e.bias, 0.01);
        EXPECT_GT(e.bias, -0.01 - ours.mirrored_within());
    }
    EXPECT_LT(before, 0.1);
}

}  // namespace
}  // namespace dapple
