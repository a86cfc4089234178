// Energy: all light that the water passes on lands on a floor or ceiling that catches everything.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/flat_scene.h"
#include "gpu/validated_device.h"
#include "ocean/water_surface.h"
#include "render/frame_renderer.h"

namespace dapple {
namespace {

constexpr double kIndex = 1.333;

/// 24 waves of 0.25 to 2 m, rms slope about 0.03: gentle enough that no facet shadows another.
scene::Waves gentle_sea() {
    scene::Waves sea;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = 0.25 * std::pow(8.0, i / 23.0);
        wave.heading = 2 * glm::pi<double>() * uniform(random);
        wave.phase = 2 * glm::pi<double>() * uniform(random);
        wave.amplitude = 0.0014 * wave.length;
        sea.waves.push_back(wave);
    }
    return sea;
}

/// Flux through the surface for a sun of unit irradiance, in double over the mesh: per triangle the area that
/// faces the light times the share that the light's angle to the vertex normals lets through (mean of the
/// corners).
struct MeshFlux {
    double transmitted = 0;
    double reflected = 0;
};

MeshFlux flux_through(const scene::WaterMesh& water, glm::dvec3 direction) {
    MeshFlux sum;
    const auto& [positions, normals, uv, triangles] = water.mesh;
    for (const glm::uvec3& triangle : triangles) {
        const glm::dvec3 a = positions[triangle.x], b = positions[triangle.y], c = positions[triangle.z];
        const double facing = -0.5 * glm::dot(glm::cross(b - a, c - a), direction);
        double transmittance = 0;
        for (int corner = 0; corner < 3; ++corner) {
            const double cos_i = -glm::dot(direction, normals[triangle[corner]]);
            const double i = std::acos(cos_i), t = std::asin(std::sin(i) / kIndex);
            const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
            transmittance += (1 - 0.5 * (s * s + p * p)) / 3;
        }
        sum.transmitted += facing * transmittance;
        sum.reflected += facing * (1 - transmittance);
    }
    return sum;
}

double flux_on_pixels(const render::RenderedFrame& frame, double pixel_area) {
    double sum = 0;
    for (const float value : frame.linear.find("E.R")->values) sum += value;
    return sum * pixel_area;
}

scene::FrameState sea_over_floor(double zenith_degrees) {
    scene::FrameState state = test::pool_over_floor(4, 2, 8, 512);
    // The floor reaches out of the patch, in water there too.
    state.water->extent.kind = scene::ExtentKind::open_water;
    state.water->surface.waves = gentle_sea();
    state.water->absorption = glm::dvec3(0);
    state.caustics.method = "photon_splatting";
    state.caustics.photon_splatting.map_resolution = 1024;
    state.lights = {test::sun_from_zenith(zenith_degrees)};
    return state;
}

// 1e-4: the edge of the patch is rasterised in whole texels (2e-5 of the flux, see caustic_map), and splats
// are sampled at pixel centres, which is exact on average only.
constexpr double kTolerance = 1e-4;

/// 8 m of receiver in 512^2 pixels, looked at squarely by a camera on the light's side.
void expect_flux(const scene::FrameState& state, double MeshFlux::*part) {
    render::FrameRenderer renderer(test::validated_device());
    FrameStats stats;
    const double landed = flux_on_pixels(renderer.render(state, stats), std::pow(8.0 / 512, 2));
    const scene::Light& sun = state.lights[0];
    const double expected =
        sun.irradiance.x * (flux_through(ocean::WaterSurface(*state.water).mesh(0), sun.direction).*part);
    printf("flux landed over flux through the surface: 1 %+.2e\n", landed / expected - 1);
    EXPECT_NEAR(landed, expected, kTolerance * expected);
}

TEST(Energy, FloorCatchesTheRefractedFlux) {
    scene::FrameState state = sea_over_floor(30);
    state.camera.position.x = state.camera.target.x =
        2 * std::tan(std::asin(std::sin(glm::radians(30.0)) / kIndex));
    expect_flux(state, &MeshFlux::transmitted);
}

TEST(Energy, CeilingCatchesTheReflectedFlux) {
    scene::FrameState state = sea_over_floor(60);
    const double height = 3, across = height * std::tan(glm::radians(60.0));
    // Beside the patch, so that it does not shade the water on the light's way down.
    state.objects = {test::level_plane("ceiling", height, 9)};
    state.objects[0].transform.position.x = across + 0.5;
    state.camera.position = {across, 0.5, 0};
    state.camera.target = {across, 1, 0};
    expect_flux(state, &MeshFlux::reflected);
}

}  // namespace
}  // namespace dapple
