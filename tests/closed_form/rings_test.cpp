// Open water of 10 km as nested rings about the camera: E under it is that of flat water's closed form and of
// a regular grid of a pool.
#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "ocean/water_surface.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kDepth = 2;
constexpr int kPixels = 96;

std::vector<float> irradiance(const scene::FrameState& state, const char* channel = "E.G") {
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    return renderer.render(state, stats).linear.find(channel)->values;
}

/// 10 km of water; the camera looks down over 1.6 m of its floor, `shift` m from the middle along x and z,
/// where floats step by up to half a millimetre.
scene::FrameState open_water(double shift) {
    scene::FrameState state = test::pool_over_floor(1e4, kDepth, 1.6, kPixels);
    state.water->rings = {.inner_size = 8, .cells = 128};
    state.objects = {test::level_plane("floor", -kDepth, 2e4)};
    state.lights = {test::sun_from_zenith(30)};
    for (glm::dvec3* p : {&state.camera.position, &state.camera.target}) {
        p->x += shift;
        p->z += shift;
    }
    return state;
}

class Rings : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(CameraFromTheMiddle, Rings, testing::Values(0.0, 4321.73), [](const auto& shift) {
    return std::to_string(static_cast<int>(shift.param)) + "m";
});

TEST_P(Rings, FlatWaterIsTheClosedForm) {
    scene::FrameState state = open_water(GetParam());
    const test::FlatFloor floor = test::flat_floor(30, kDepth, state.water->refractive_index);
    const double expected =
        state.lights[0].irradiance.y * floor.irradiance * std::exp(-state.water->absorption.y * floor.way);
    for (const char* method : {"sliced_beams", "photon_splatting"}) {
        state.caustics.method = method;
        state.caustics.map.inner_size = 8;
        state.caustics.map.map_resolution = 512;
        double mean = 0, worst = 0;
        for (const float value : irradiance(state)) {
            mean += value / (kPixels * kPixels);
            worst = std::max(worst, std::abs(value / expected - 1));
        }
        printf("%s at %.0f m: E off by %.1e in the worst pixel, %.1e in the mean\n", method, GetParam(),
               worst, std::abs(mean / expected - 1));
        // As on regular grids (flat_water_test.cpp, methods/splatting_test.cpp).
        EXPECT_LT(worst, 5e-3) << method;
        EXPECT_NEAR(mean, expected, 1e-4 * expected) << method;
    }
}

TEST_P(Rings, ASeaIsThatOfARegularGrid) {
    scene::FrameState state = open_water(GetParam());
    state.water->surface.waves.waves = {{.length = 1.1, .heading = 0.4, .amplitude = 0.006},
                                        {.length = 1.9, .heading = 2.1, .amplitude = 0.012, .phase = 1},
                                        {.length = 40, .heading = -1, .amplitude = 0.3, .phase = 2}};
    const std::vector<float> rings = irradiance(state);
    const double cell = ocean::WaterSurface(*state.water).mesh(0).rings.front().cell;
    const auto regular = [&](double cells_of) {
        scene::FrameState pool = state;
        pool.water->rings = {};
        pool.water->extent.center = {GetParam(), GetParam()};
        pool.water->extent.size = {12, 12};
        pool.water->mesh_cells = static_cast<int>(std::lround(12 / cells_of));
        return irradiance(pool);
    };
    const std::vector<float> fine = regular(cell / 4), same = regular(cell);
    const auto difference = [&](const std::vector<float>& a) {
        double sum = 0, all = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            sum += std::abs(a[i] - fine[i]);
            all += fine[i];
        }
        return sum / all;
    };
    printf(
        "at %.0f m: rings differ from a grid four times finer by %.2e, a regular grid of their cells by "
        "%.2e\n",
        GetParam(), difference(rings), difference(same));
    // Cells of 6 cm are 18 a wave: second order, (pi / 18)^2 / 2 of the curvatures that focus, is 1.5 %.
    EXPECT_LT(difference(rings), 0.015);
    // Neither lattice is the better one.
    EXPECT_LT(difference(rings), 1.5 * difference(same));
    EXPECT_GT(difference(rings), 1e-5) << "else this tells of nothing";
}

}  // namespace
}  // namespace dapple
