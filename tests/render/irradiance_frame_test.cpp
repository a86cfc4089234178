// Filters over E and smaller buffers of it, through the whole of a frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr int kWidth = 45;
constexpr int kHeight = 30;

struct Rendered {
    image::Image image;
    FrameStats stats;
    const std::vector<float>& channel(const char* name) const { return image.find(name)->values; }
};

Rendered render(const scene::FrameState& state) {
    render::FrameRenderer renderer(test::validated_device());
    Rendered rendered;
    rendered.image = renderer.render(state, rendered.stats).linear;
    return rendered;
}

/// A floor below flat water, looked at obliquely from under water.
scene::FrameState flat_pool(const char* method) {
    scene::FrameState state = test::pool_over_floor(10, 2, 1, kWidth);
    state.clip.height = kHeight;
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {-1.2, -0.4, 0.3};
    state.camera.target = {0, -2, 0};
    state.camera.up = {0, 1, 0};
    state.camera.field_of_view = glm::radians(40.0);
    state.water->absorption = glm::dvec3(0);
    state.lights = {test::sun_from_zenith(30)};
    state.caustics.method = method;
    state.caustics.map.map_resolution = 512;
    return state;
}

scene::FrameState with_column(scene::FrameState state) {
    scene::Object column;
    column.name = "column";
    column.shape = scene::Shape::box;
    column.size = {0.3, 3, 0.3};
    column.transform.position = {0, -1, 0};
    column.transform.rotation = {0, 0.5, 0};
    state.objects.push_back(column);
    return state;
}

scene::FrameState scaled(scene::FrameState state, scene::BufferScale scale) {
    state.caustics.buffer_scale = scale;
    return state;
}

constexpr scene::BufferScale kScales[] = {scene::BufferScale::half, scene::BufferScale::quarter};

/// All weights are of one value, which sliced_beams finds for pixels of any size. Splats are widened by the
/// pixel's size, and even to 5 % only.
TEST(BufferScaleFrame, FlatWaterIsThatOfThePicture) {
    const double expected = 3 * test::flat_floor(30, 2, 1.333).irradiance;
    for (const auto& [method, tolerance] : {std::pair("sliced_beams", 1e-4), {"photon_splatting", 5e-2}}) {
        const scene::FrameState state = flat_pool(method);
        const Rendered full = render(state);
        for (const scene::BufferScale scale : kScales) {
            const Rendered found = render(scaled(state, scale));
            EXPECT_EQ(found.channel("covered"), full.channel("covered"));
            for (std::size_t i = 0; i < found.image.pixels(); ++i) {
                EXPECT_NEAR(found.channel("E.R")[i], full.channel("E.R")[i], tolerance * expected) << i;
                EXPECT_NEAR(found.channel("E.R")[i], expected, 2 * tolerance * expected) << i;
            }
        }
    }
}

/// Light under flat water is even on each face of a column and on the floor about it, but for shadows: a
/// pixel may differ only where its own object is not evenly lit within two pixels of the buffer.
TEST(BufferScaleFrame, ThereAreNoHalosAboutAColumn) {
    const scene::FrameState state = with_column(flat_pool("sliced_beams"));
    const Rendered full = render(state);
    const std::vector<float>& e = full.channel("E.R");
    const std::vector<float>&x = full.channel("N.X"), &y = full.channel("N.Y"), &z = full.channel("N.Z");
    const float whole = *std::max_element(e.begin(), e.end());
    const auto evenly_lit = [&](int column, int row, int reach) {
        const auto i = static_cast<std::size_t>(row * kWidth + column);
        for (int v = std::max(0, row - reach); v <= std::min(kHeight - 1, row + reach); ++v) {
            for (int u = std::max(0, column - reach); u <= std::min(kWidth - 1, column + reach); ++u) {
                const auto j = static_cast<std::size_t>(v * kWidth + u);
                if (x[j] == x[i] && y[j] == y[i] && z[j] == z[i] && std::abs(e[j] - e[i]) > 1e-3f * whole)
                    return false;
            }
        }
        return true;
    };
    for (const scene::BufferScale scale : kScales) {
        const Rendered found = render(scaled(state, scale));
        const int side = scale == scene::BufferScale::half ? 2 : 4;
        std::size_t compared = 0;
        for (int row = 0; row < kHeight; ++row) {
            for (int column = 0; column < kWidth; ++column) {
                if (!evenly_lit(column, row, 2 * side)) continue;
                ++compared;
                const auto i = static_cast<std::size_t>(row * kWidth + column);
                EXPECT_NEAR(found.channel("E.R")[i], e[i], 2e-3f * whole) << column << "," << row;
            }
        }
        EXPECT_GT(compared, found.image.pixels() / 3);
    }
}

/// Uneven light: a bent sea. The mean over the picture stays, as coarse pixels hold means over their area.
scene::FrameState wavy_pool(const char* method) {
    scene::FrameState state = flat_pool(method);
    state.water->surface.type = scene::WaterSurfaceType::waves;
    state.water->surface.waves.waves.push_back({0.9, 0.4, 0.004, 0.3, {}});
    state.clip.samples = 4;
    return state;
}

double mean(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += static_cast<double>(value);
    return sum / static_cast<double>(values.size());
}

/// Inside bilinear weights sum to the same for each coarse pixel; at the picture's border, a share of 1 / 45
/// + 1 / 30 a pixel, half coarse pixels are repeated. Splats have their own bias, which depends on the pixel.
TEST(BufferScaleFrame, TheMeanOfUnevenLightStays) {
    for (const auto& [method, tolerance] : {std::pair("sliced_beams", 1e-3), {"photon_splatting", 3e-3}}) {
        const scene::FrameState state = wavy_pool(method);
        const double expected = mean(render(state).channel("E.R"));
        for (const scene::BufferScale scale : kScales) {
            const double found = mean(render(scaled(state, scale)).channel("E.R"));
            const int side = scale == scene::BufferScale::half ? 1 : 4;
            EXPECT_NEAR(found / expected, 1, side * tolerance) << method;
        }
    }
}

TEST(DenoisedFrame, EvenLightStaysAndIsNotMixedWithAlbedo) {
    scene::FrameState state = with_column(flat_pool("photon_splatting"));
    const Rendered plain = render(state);
    state.caustics.denoise.filter = scene::DenoiseFilter::adaptive;
    state.caustics.denoise.passes = 2;
    const Rendered found = render(state);
    EXPECT_GT(found.stats.counted("power before denoising, W"), 0);
    EXPECT_NEAR(
        found.stats.counted("power after denoising, W") / found.stats.counted("power before denoising, W"), 1,
        1e-5);
    EXPECT_NE(found.channel("E.R"), plain.channel("E.R"));  // shadows are softened
    EXPECT_EQ(found.channel("albedo.R"), plain.channel("albedo.R"));
    EXPECT_EQ(found.channel("direct.R"), plain.channel("direct.R"));
    // There is no extinction: what the camera sees is albedo / pi E.
    for (std::size_t i = 0; i < found.image.pixels(); ++i) {
        EXPECT_NEAR(found.channel("caustics.R")[i],
                    found.channel("albedo.R")[i] / glm::pi<float>() * found.channel("E.R")[i], 1e-6f);
    }
}

TEST(DenoisedFrame, PaperTellsItsChangeOfPower) {
    scene::FrameState state = wavy_pool("photon_splatting");
    state.caustics.map.map_resolution = 64;
    state.caustics.photon_splatting.footprint = scene::PhotonFootprint::point;
    state.caustics.denoise.filter = scene::DenoiseFilter::adaptive;
    const auto change = [&] {
        const Rendered found = render(state);
        return found.stats.counted("power after denoising, W") /
                   found.stats.counted("power before denoising, W") -
               1;
    };
    EXPECT_NEAR(change(), 0, 1e-5);
    state.caustics.denoise.paper_faithful = true;
    EXPECT_GT(std::abs(change()), 0.01);
}

/// Both at once: the filter works on the buffer's pixels.
TEST(DenoisedFrame, IsFoundInTheBuffer) {
    scene::FrameState state = scaled(with_column(flat_pool("photon_splatting")), scene::BufferScale::half);
    state.caustics.denoise.filter = scene::DenoiseFilter::fixed;
    const Rendered found = render(state);
    EXPECT_GT(found.stats.counted("power before denoising, W"), 0);
    EXPECT_NEAR(
        found.stats.counted("power after denoising, W") / found.stats.counted("power before denoising, W"), 1,
        1e-5);
}

}  // namespace
}  // namespace dapple
