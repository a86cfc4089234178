// Energy: all light that the water passes on lands on a floor or ceiling that catches everything.
#include <gtest/gtest.h>

#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "gpu/validated_device.h"
#include "ocean/water_surface.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;

double flux_on_pixels(const render::RenderedFrame& frame, double pixel_area) {
    double sum = 0;
    for (const float value : frame.linear.find("E.R")->values) sum += value;
    return sum * pixel_area;
}

scene::FrameState sea_over_floor(double zenith_degrees) {
    scene::FrameState state = test::pool_over_floor(4, 2, 8, 512);
    // The floor reaches out of the patch, in water there too.
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.water->surface.waves = test::gentle_waves();
    state.water->absorption = glm::dvec3(0);
    state.caustics.method = "photon_splatting";
    state.caustics.map.map_resolution = 1024;
    state.lights = {test::sun_from_zenith(zenith_degrees)};
    return state;
}

// 1e-4: the edge of the patch is rasterised in whole texels (2e-5 of the flux, see caustic_map), and splats
// are sampled at pixel centres, which is exact on average only.
constexpr double kTolerance = 1e-4;

/// 8 m of receiver in 512^2 pixels, looked at squarely by a camera on the light's side.
void expect_flux(const scene::FrameState& state, double test::MeshFlux::*part) {
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    const double landed = flux_on_pixels(renderer.render(state, stats), std::pow(8.0 / 512, 2));
    const scene::Light& sun = state.lights[0];
    const double expected =
        sun.irradiance.x *
        (test::flux_through(ocean::WaterSurface(*state.water).mesh(0), sun.direction, kIndex).*part);
    printf("flux landed over flux through the surface: 1 %+.2e\n", landed / expected - 1);
    EXPECT_NEAR(landed, expected, kTolerance * expected);
}

TEST(Energy, FloorCatchesTheRefractedFlux) {
    scene::FrameState state = sea_over_floor(30);
    state.camera.position.x = state.camera.target.x =
        2 * std::tan(std::asin(std::sin(glm::radians(30.0)) / kIndex));
    expect_flux(state, &test::MeshFlux::transmitted);
}

TEST(Energy, CeilingCatchesTheReflectedFlux) {
    scene::FrameState state = sea_over_floor(60);
    const double height = 3, across = height * std::tan(glm::radians(60.0));
    // Beside the patch, so that it does not shade the water on the light's way down.
    state.objects = {test::level_plane("ceiling", height, 9)};
    state.objects[0].transform.position.x = across + 0.5;
    state.camera.position = {across, 0.5, 0};
    state.camera.target = {across, 1, 0};
    expect_flux(state, &test::MeshFlux::reflected);
}

}  // namespace
}  // namespace dapple
