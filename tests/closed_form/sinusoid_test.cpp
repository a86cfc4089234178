// One sinusoid under an overhead sun: the exact landing map X = x + (d + h) tan(delta) of rays refracted at a
// cos kx gives the flux between the edges of any strip of the floor.
#include <gtest/gtest.h>

#include <algorithm>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;
constexpr double kAmplitude = 0.01, kLength = 0.5, kPatch = 3, kView = 1;
constexpr int kPixels = 200;
const double kWaveNumber = 2 * glm::pi<double>() / kLength;
/// Paraxial focus below a crest: n / ((n - 1) a k^2) = 2.54 m.
const double kFocus = kIndex / ((kIndex - 1) * kAmplitude * kWaveNumber * kWaveNumber);

/// Irradiance, mean over each pixel's strip, for a sun of unit irradiance: rays 3 um apart on the whole
/// patch, the flux between two neighbours spread evenly between their landing points.
std::vector<double> exact_irradiance(double depth) {
    constexpr int rays = 1000000;
    const double pixel = kView / kPixels;
    std::vector<double> flux(kPixels, 0);
    double previous_landing = 0;
    for (int i = 0; i <= rays; ++i) {
        const double x = kPatch * (static_cast<double>(i) / rays - 0.5);
        const double height = kAmplitude * std::cos(kWaveNumber * x);
        const double tilt = std::atan(-kAmplitude * kWaveNumber * std::sin(kWaveNumber * x));
        const double inside = std::asin(std::sin(tilt) / kIndex);
        const double landing = x + (depth + height) * std::tan(tilt - inside);
        // Fresnel at angle `tilt`; near 0 the sine form is 0 / 0 and the normal value holds to 1e-9.
        double transmittance = 1 - std::pow((kIndex - 1) / (kIndex + 1), 2);
        if (std::abs(tilt) > 1e-4) {
            const double s = std::sin(tilt - inside) / std::sin(tilt + inside);
            const double p = std::tan(tilt - inside) / std::tan(tilt + inside);
            transmittance = 1 - 0.5 * (s * s + p * p);
        }
        if (i > 0) {
            const double low = std::min(landing, previous_landing),
                         high = std::max(landing, previous_landing);
            const double carried = transmittance * kPatch / rays;
            const int first = std::max(0, static_cast<int>(std::floor((low + 0.5 * kView) / pixel)));
            const int last =
                std::min(kPixels - 1, static_cast<int>(std::floor((high + 0.5 * kView) / pixel)));
            for (int column = first; column <= last; ++column) {
                const double left = column * pixel - 0.5 * kView;
                const double overlap = std::min(high, left + pixel) - std::max(low, left);
                flux[static_cast<std::size_t>(column)] +=
                    high > low ? carried * std::max(0.0, overlap) / (high - low) : carried;
            }
        }
        previous_landing = landing;
    }
    for (double& value : flux) value /= pixel;
    return flux;
}

double relative_l1_error(double depth, int resolution) {
    scene::FrameState state = test::pool_over_floor(kPatch, depth, 0, kPixels);
    state.clip.height = 16;
    state.camera.view_height = kView * 16 / kPixels;
    state.water->extent.size = {kPatch, 1};
    state.water->absorption = glm::dvec3(0);
    state.water->mesh_cells = 1500;  // 2 mm: the mesh's own error is far below the photons'
    state.water->surface.waves.waves = {{kLength, 0, kAmplitude, 0}};
    state.caustics.method = "photon_splatting";
    state.caustics.map.map_resolution = resolution;
    state.lights = {test::sun_from_zenith(0)};
    state.lights[0].irradiance = glm::dvec3(1);
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    const render::RenderedFrame frame = renderer.render(state, stats);
    const std::vector<float>& landed = frame.linear.find("E.R")->values;
    const std::vector<double> exact = exact_irradiance(depth);
    double error = 0, sum = 0;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < kPixels; ++x) {
            const double expected = exact[static_cast<std::size_t>(x)];
            error += std::abs(landed[static_cast<std::size_t>(y * kPixels + x)] - expected);
            sum += expected;
        }
    }
    return error / sum;
}

class Sinusoid : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(DepthOverFocus, Sinusoid, testing::Values(0.5, 2.0),
                         [](const auto& depth) { return depth.param < 1 ? "before" : "behind"; });

TEST_P(Sinusoid, ErrorFallsUntilTheKernelIsAPixelWide) {
    // Photons 11.7, 5.9, 2.9 and 1.5 mm apart on the water, pixels of 5 mm.
    double errors[4];
    for (int level = 0; level < 4; ++level) {
        errors[level] = relative_l1_error(GetParam() * kFocus, 256 << level);
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

}  // namespace
}  // namespace dapple
