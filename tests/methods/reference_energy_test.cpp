// The brute-force reference catches all light, by any chain of events.
#include "methods/reference/reference.h"

#include <gtest/gtest.h>

#include "methods/reference_frame.h"

namespace dapple {
namespace {

using namespace test;

/// Light that the water transmits, per unit of the sun's irradiance, for waves along x and a sun at -x: a
/// fine grid, whose points are hidden where an earlier one reaches higher above the slope of the light.
struct Transmitted {
    double lit, all;  ///< with and without shadows
};
Transmitted transmitted_flux(const scene::Water& water, const glm::dvec3& direction) {
    const ocean::WaterSurface surface(water);
    const double climb = -direction.y / direction.x;
    constexpr int steps = 200000;
    Transmitted sum{0, 0};
    double horizon = -1e9;
    for (int i = 0; i < steps; ++i) {
        const double x = water.extent.size.x * ((i + 0.5) / steps - 0.5);
        const ocean::SurfaceSample at = surface.sample(x, 0, 0);
        const glm::dvec3 normal(-at.slope.x, 1, -at.slope.y);
        const double facing = -dot(direction, normal);
        const bool hidden = at.height + climb * x < horizon;
        horizon = std::max(horizon, at.height + climb * x);
        if (facing <= 0) continue;
        const double angle = std::acos(std::min(1.0, facing / length(normal)));
        const double flux = facing * (1 - refract(angle, 1, water.refractive_index).reflectance);
        sum.all += flux;
        if (!hidden) sum.lit += flux;
    }
    const double cell = water.extent.size.x * water.extent.size.y / steps;
    return {cell * sum.lit, cell * sum.all};
}

/// All that lands on a floor that catches everything, over the flux that comes in; and the standard error.
struct Catch {
    double share, error;
};
Catch caught(Frame& frame, double flux) {
    const scene::FrameState& state = frame.scene.state;
    const LayerResult result = frame.render();
    const double pixel = std::pow(state.camera.view_height / state.clip.height, 2);
    double sum = 0, variance = 0;
    for (std::size_t i = 0; i < result.irradiance.size(); ++i) {
        sum += static_cast<double>(result.irradiance[i].x);
        variance += static_cast<double>(result.data[0].values[i]);
    }
    return {pixel * sum / flux, pixel * std::sqrt(variance) / flux};
}

TEST(Reference, CatchesAllTransmittedLight) {
    scene::FrameState state = small_pool(1, 0.5, 2, 64);
    state.objects[0].size = {2, 1, 2};
    state.water->absorption = glm::dvec3(0);
    state.water->surface.waves.waves = {{0.4, 0, 0.012, 0.3}, {0.23, 0, 0.005, 1.1}};
    state.lights = {test::sun_from_zenith(40)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    const double flux = transmitted_flux(*state.water, state.lights[0].direction).all;
    Frame frame(state);
    const Catch found = caught(frame, flux);
    printf("caught %.6f +- %.6f\n", found.share, found.error);
    // The landing points of neighbouring strata share out between pixels: their errors cancel in the sum,
    // which is nearer than its standard error for independent pixels says.
    EXPECT_NEAR(found.share, 1, 3 * found.error);
    EXPECT_NEAR(found.share, 1, 1e-4);

    // The same surface as the triangles of a file, 3.3 mm wide.
    state.water->mesh_cells = 300;
    Frame read(state);
    read.scene.state.water->surface.type = scene::WaterSurfaceType::mesh_sequence;
    const Catch on_triangles = caught(read, flux);
    printf("caught from triangles %.6f +- %.6f\n", on_triangles.share, on_triangles.error);
    EXPECT_NEAR(on_triangles.share, 1, 1e-4 + 3 * on_triangles.error);
}

TEST(Reference, CatchesTheLightOfASpectrum) {
    // The pool ends between pixels, since those count the receivers of one medium only.
    scene::FrameState state = small_pool(2, 0.5, 4, 64);
    state.objects[0].size = {4, 1, 4};
    state.camera.position.y = -0.4;  // below all troughs
    state.water->absorption = glm::dvec3(0);
    state.water->surface.type = scene::WaterSurfaceType::spectrum;
    state.water->surface.spectrum.wind_speed = 2;
    state.water->surface.spectrum.cutoff_length = 0.25;
    state.lights = {test::sun_from_zenith(40)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    Frame frame(state);
    // The sea is periodic, so that the mean over the points of its grid is an integral.
    const ocean::SurfaceGrid grid = ocean::WaterSurface(*state.water).grid(0, ocean::kSlope);
    double flux = 0, steepest = 0;
    for (int row = 0; row + 1 < grid.rows; ++row) {
        for (int column = 0; column + 1 < grid.columns; ++column) {
            const auto at = static_cast<std::size_t>(row * grid.columns + column);
            const glm::dvec3 normal(-grid[ocean::Field::slope_x][at], 1, -grid[ocean::Field::slope_z][at]);
            const double facing = -dot(state.lights[0].direction, normal);
            const double angle = std::acos(std::min(1.0, facing / length(normal)));
            flux += facing * (1 - refract(angle, 1, state.water->refractive_index).reflectance);
            steepest = std::max(steepest, std::hypot(normal.x, normal.z));
        }
    }
    ASSERT_GT(steepest, 0.1);  // it has waves, which the camera does not meet
    ASSERT_LT(frame.scene.water->largest_height, 0.3);
    flux *= 4.0 / ((grid.rows - 1) * (grid.columns - 1));
    const Catch found = caught(frame, flux);
    printf("caught %.6f +- %.6f\n", found.share, found.error);
    EXPECT_NEAR(found.share, 1, 3 * found.error);
    EXPECT_NEAR(found.share, 1, 1e-4);
}

TEST(Reference, WavesShadowEachOther) {
    // A sun 8 degrees high over slopes of up to 0.38: a third of the water lies in shadow.
    scene::FrameState state = small_pool(1, 0.5, 4, 64);
    state.objects[0].size = {4, 1, 4};
    state.water->absorption = glm::dvec3(0);
    state.water->surface.waves.waves = {{0.25, 0, 0.015, 0.3}};
    state.lights = {test::sun_from_zenith(82)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    const Transmitted exact = transmitted_flux(*state.water, state.lights[0].direction);
    EXPECT_LT(exact.lit, 0.8 * exact.all);
    Frame frame(state);
    const Catch found = caught(frame, exact.lit);
    printf("caught %.5f +- %.5f of %.3f\n", found.share, found.error, exact.lit / exact.all);
    EXPECT_NEAR(found.share, 1, 3 * found.error);
}

TEST(Reference, MirrorUnderWater) {
    // Straight down onto a mirror at 45 degrees, and along the water to a wall: 2 m of way everywhere.
    scene::FrameState state = small_pool(2, 5, 0.4, 32);
    scene::Object mirror = test::level_plane("mirror", -1, 1);
    mirror.transform.rotation.z = 45 * scene::kDegree;
    mirror.material = {{0.9, 0.8, 0.7}, "", 1, true};
    scene::Object wall = test::level_plane("wall", -1, 3);
    wall.transform.position.x = -1;
    wall.transform.rotation.z = -90 * scene::kDegree;
    state.objects = {mirror, wall};
    state.camera.position = {-0.8, -1, 0};
    state.camera.target = {-1, -1, 0};
    state.camera.up = {0, 1, 0};
    state.lights = {test::sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    const test::FlatFloor exact = test::flat_floor(0, 2, state.water->refractive_index);
    Frame frame(state);
    const LayerResult result = frame.render();
    for (int channel = 0; channel < 3; ++channel) {
        const double e = state.lights[0].irradiance[channel] * exact.irradiance *
                         mirror.material.color[channel] * std::exp(-2 * state.water->absorption[channel]);
        expect_agreement(agreement(result, std::vector<double>(1024, e), channel));
    }
    frame.options.mirrors = false;
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(Reference, SecondCrossing) {
    // Reflected by the water, by a mirror over it, and refracted on its way back: to the floor. The sun's
    // own refracted light is not asked for.
    scene::FrameState state = small_pool(8, 1, 0.6, 16);
    state.water->extent = {scene::ExtentKind::pool, {0.9, 0}, {4, 1}};
    scene::Object mirror = test::level_plane("mirror", 1, 1.5);
    mirror.transform.position.x = 0.75;
    mirror.material = {{0.9, 0.8, 0.7}, "", 1, true};
    state.objects.push_back(mirror);
    state.camera.position.x = state.camera.target.x = 2.3;
    state.lights = {test::sun_from_zenith(45)};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    frame.chains = {{0, light::Event::reflection}};
    const Refraction at = refract(glm::radians(45.0), 1, state.water->refractive_index);
    const double e = 3 * std::cos(glm::radians(45.0)) * at.reflectance * 0.9 * (1 - at.reflectance) *
                     std::exp(-state.water->absorption.x / std::cos(at.angle));
    expect_agreement(agreement(frame.render(), std::vector<double>(256, e)));
    frame.options.second_crossings = false;
    for (const glm::vec3& dark : frame.render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

TEST(Reference, DispersionLandsColoursApart) {
    // Over flat water only the transmittance tells the indices apart, a little; the channels get their own.
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.objects[0].size = {1, 1, 1};
    state.water->dispersion = 0.2;
    state.water->absorption = glm::dvec3(0);
    state.lights = {test::sun_from_zenith(60)};
    state.lights[0].irradiance = glm::dvec3(1);
    state.caustics.reference = kOneRound;
    Frame frame(state);
    const LayerResult result = frame.render();
    for (int channel = 0; channel < 3; ++channel) {
        const double n = state.water->refractive_index + 0.1 * (channel - 1);
        expect_agreement(
            agreement(result, std::vector<double>(256, test::flat_floor(60, 1, n).irradiance), channel));
    }
}

TEST(Reference, MeshReceivesWhatItsPlaneDoes) {
    scene::FrameState state = small_pool(3, 1, 1, 32);
    state.objects[0].shape = scene::Shape::mesh;
    state.objects[0].transform.position.y = -1;
    state.lights = {test::sun_from_zenith(35)};
    state.caustics.reference = kOneRound;
    Frame frame(state);
    // A fan of slivers and wide triangles about a point off the middle.
    auto mesh = std::make_shared<scene::TriangleMesh>();
    mesh->positions = {{0.13, 0, 0.21}};
    constexpr glm::uint spokes = 17;
    for (glm::uint i = 0; i < spokes; ++i) {
        const double angle = -2 * glm::pi<double>() * std::pow(static_cast<double>(i) / spokes, 1.5);
        mesh->positions.push_back({3 * std::cos(angle), 0, 3 * std::sin(angle)});
        mesh->triangles.push_back({0, i + 1, (i + 1) % spokes + 1});
    }
    frame.scene.object_meshes[0] = mesh;
    const test::FlatFloor exact = test::flat_floor(35, 1, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    expect_agreement(agreement(frame.render(), std::vector<double>(1024, e)));
}

TEST(Reference, SeenFromAboveInPerspective) {
    // E of the floor is the same everywhere, whatever the size of the pixels on it: cells from near to far.
    scene::FrameState state = small_pool(5, 1, 1, 32);
    state.camera.projection = scene::Projection::perspective;
    state.camera.position = {0, 0.6, 2.2};
    state.camera.target = {0, -1, 0};
    state.camera.up = {0, 1, 0};
    state.camera.field_of_view = 40 * scene::kDegree;
    state.lights = {test::sun_from_zenith(20)};
    state.caustics.reference = kOneRound;
    const test::FlatFloor exact = test::flat_floor(20, 1, state.water->refractive_index);
    const double e = 3 * exact.irradiance * std::exp(-state.water->absorption.x * exact.way);
    expect_agreement(agreement(Frame(state).render(), std::vector<double>(1024, e)));
}

TEST(Reference, WallsHaveTwoSides) {
    // A level plate in the water: light from above is on its upper side, and its lower side is dark.
    scene::FrameState state = small_pool(3, 1, 1, 16);
    state.lights = {test::sun_from_zenith(0)};
    state.caustics.reference = kOneRound;
    EXPECT_GT(Frame(state).render().irradiance[100].x, 1);
    state.camera.position.y = -2;
    state.camera.target.y = 0;
    for (const glm::vec3& dark : Frame(state).render().irradiance) ASSERT_EQ(dark, glm::vec3(0));
}

}  // namespace
}  // namespace dapple
