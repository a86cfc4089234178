#include <gtest/gtest.h>

#include <numeric>

#include "light/caustic_map.h"
#include "methods/caustic_mesh/cell_drawing.h"
#include "methods/flat_water_light.h"

namespace dapple {
namespace {

using light::Event;
namespace caustic_mesh = methods::caustic_mesh;
using test::flat_pool;
using test::kMeshIndex;
using test::kPoolFloor;

/// Largest relative error of E over all receivers within 1.5 m of the middle, and all channels.
double worst_error(const scene::FrameScene& scene, const test::Plane& plane, const view::ReceiverLayer& layer,
                   const methods::LayerResult& result) {
    double worst = 0;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        const glm::dvec3 point = glm::dvec3(layer.position[i]) + scene.origin;
        if (std::max(std::abs(point.x), std::abs(point.z)) > 1.5) continue;
        ++seen;
        const glm::dvec3 error =
            glm::dvec3(result.irradiance[i]) / under_flat_water(scene, plane, point) - 1.0;
        worst = std::max({worst, std::abs(error.r), std::abs(error.g), std::abs(error.b)});
    }
    EXPECT_GT(seen, layer.pixels() / 4);
    return worst;
}

TEST(CausticMesh, FlatWaterComesOutFlatAtAnyRatioOfCellsToPixels) {
    for (const double zenith : {0.0, 50.0})
        // 6 m of water against 2 m in 96 pixels: cells from 9 pixels to a seventh of one, commensurate or
        // not.
        for (const int resolution : {31, 144, 331, 800}) {
            SCOPED_TRACE(testing::Message() << "zenith " << zenith << ", " << resolution);
            const scene::FrameScene scene = flat_pool(zenith, resolution, 96);
            const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
            // Coverage is exact, so that what is left are positions in float against cells: 2^-24 of 6 m each
            // against 6 m / resolution.
            EXPECT_LT(worst_error(scene, kPoolFloor, layer, test::draw_mesh(scene, layer)),
                      2e-5 + 4e-7 * resolution);
        }
}

TEST(CausticMesh, FlatWaterComesOutFlatInPerspective) {
    for (const int resolution : {50, 300, 700}) {
        SCOPED_TRACE(resolution);
        scene::FrameScene scene = flat_pool(30, resolution, 128);
        scene.state.camera.projection = scene::Projection::perspective;
        scene.state.camera.position = {-1.6, -0.5, 0.7};
        scene.state.camera.target = {-0.2, -1.5, 0};
        scene.state.camera.up = {0, 1, 0};
        scene.state.camera.field_of_view = 0.7;
        const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
        EXPECT_LT(worst_error(scene, kPoolFloor, layer, test::draw_mesh(scene, layer)), 1e-4);
    }
}

TEST(CausticMesh, CascadesShareTheLightOfFlatWater) {
    for (const double view : {1.9, 5.0}) {
        scene::FrameScene scene = flat_pool(20, 64, 128);
        scene.state.caustics.map.cascades = 3;
        scene.state.caustics.map.inner_size = 1.2;
        scene.state.caustics.map.cascade_center = scene::CascadeCenter::extent;
        scene.state.camera.view_height = view;
        const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
        FrameStats stats;
        const auto result = test::draw_mesh(scene, Event::transmission, {&layer, 1}, stats);
        // Within 1.5 m of the middle lie both borders. Where ramps cross in the corners of a box the share is
        // no linear function of the place, which triangles of two lattices interpolate differently.
        EXPECT_LT(worst_error(scene, kPoolFloor, layer, result[0]), 1e-3) << view;
    }
}

TEST(CausticMesh, ASlopedFloorIsLitByItsClosedForm) {
    const double tilt = glm::radians(25.0);
    for (const int resolution : {200, 800}) {
        SCOPED_TRACE(resolution);
        scene::FrameScene scene = flat_pool(40, resolution, 96);
        const test::Plane slope{{0, -1.5, 0}, {-std::sin(tilt), std::cos(tilt), 0}};
        scene.state.objects = {test::plane_object(slope.point, 20, {0, 0, tilt})};
        const view::ReceiverLayer layer = test::receivers_on(scene, slope, true);
        // Light fades by exp(-0.4 / m): over a cell's 3 cm linear but for (0.4 0.03)^2 / 8.
        EXPECT_LT(worst_error(scene, slope, layer, test::draw_mesh(scene, layer)), 1e-4);
    }
}

TEST(CausticMesh, APointLightLightsTheFloorByItsClosedForm) {
    scene::FrameScene scene = flat_pool(0, 600, 96);
    scene.origin = glm::dvec3(0);
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0.4, 1.2, -0.3};
    lamp.intensity = {7, 7, 7};
    scene.state.lights = {lamp};
    scene.state.water->absorption = {0, 0, 0};
    const view::ReceiverLayer layer = test::receivers_on(scene, kPoolFloor, true);
    const methods::LayerResult result = test::draw_mesh(scene, layer);
    const double a = 1.2, b = 1.5;
    double worst = 0;
    for (std::size_t k = 0; k < layer.pixels(); ++k) {
        const glm::dvec3 p(layer.position[k]);
        const double r = std::hypot(p.x - 0.4, p.z + 0.3);
        double low = 0, high = glm::half_pi<double>();
        for (int step = 0; step < 60; ++step) {  // r(i) grows
            const double i = 0.5 * (low + high);
            (a * std::tan(i) + b * std::tan(std::asin(std::sin(i) / kMeshIndex)) < r ? low : high) = i;
        }
        const double i = std::max(low, 1e-6), t = std::asin(std::sin(i) / kMeshIndex);
        // E = I (1 - F) sin(i) / (r dr/di).
        const double rate =
            a / std::pow(std::cos(i), 2) + b * std::cos(i) / (kMeshIndex * std::pow(std::cos(t), 3));
        const double radius = a * std::tan(i) + b * std::tan(t);
        const double expected = 7 * test::transmittance(i) * std::sin(i) / (radius * rate);
        worst = std::max(worst, std::abs(static_cast<double>(result.irradiance[k].g) / expected - 1));
    }
    // Cells of 1 cm against lengths of 1 m: second differences are 1e-4, of which linear brightness misses a
    // fraction. (Of one brightness a cell: 1e-2.)
    EXPECT_LT(worst, 1e-4);
}

/// Flux on level receivers over that of the rays, for a sea; and cells that were widened.
struct Caught {
    double share = 0, widened = 0;
};

Caught caught_of_sea(Event event, double view, int pixels) {
    const bool down = event == Event::transmission;
    scene::FrameScene scene = test::water_scene({4, 4});
    scene.state.lights = {test::sun(down ? 25 : 65, 0)};  // travels along -x
    scene.state.lights[0].irradiance = {1, 1, 1};
    scene.state.water->absorption = {0, 0, 0};
    scene.state.caustics.map.map_resolution = 400;
    // Gentler waves for the reflection: its directions turn by twice the slope, and must all meet the
    // ceiling, which must not shadow the water.
    test::add_water(scene, test::gentle_sea(down ? 0.0032 : 0.001), 200, 200);
    test::Plane plane{{0, -2, 0}};
    if (down) {
        test::look(scene, glm::ivec2(pixels), view, {0, -0.1, 0}, {0, -1, 0}, {0, 0, -1});
        scene.state.objects = {test::plane_object({0, -2, 0}, 60)};
    } else {
        test::look(scene, glm::ivec2(pixels), view, {-6, 0.5, 0}, {-6, 2, 0}, {0, 0, -1});
        scene.state.objects = {test::plane_object({-6, 2, 0}, 14, {glm::pi<double>(), 0, 0})};
        plane = {{0, 2, 0}, {0, -1, 0}};
    }
    FrameStats stats;
    const view::ReceiverLayer layer = test::receivers_on(scene, plane, down);
    const methods::LayerResult result = test::draw_mesh(scene, event, {&layer, 1}, stats)[0];
    double sum = 0;
    for (const glm::vec3& e : result.irradiance) sum += static_cast<double>(e.g);
    light::CausticMapper mapper(test::validated_device());
    const rays::RayScene rays(scene);
    const light::BeamMesh mesh = mapper.trace(scene, rays, 0, {event}, scene.state.caustics.map, stats)[0];
    const double flux = std::accumulate(mesh.flux.begin(), mesh.flux.end(), 0.0);
    EXPECT_GT(flux, down ? 10 : 0.5);
    return {sum * std::pow(view / pixels, 2) / flux, stats.counted("cells widened")};
}

TEST(CausticMesh, LevelReceiversCatchAllFluxOfASea) {
    // Nothing is lost at folds: coverage is exact, and each cell has its flux; what is left is round-off.
    EXPECT_NEAR(caught_of_sea(Event::transmission, 10, 320).share, 1, 1e-6);
    EXPECT_NEAR(caught_of_sea(Event::reflection, 16, 320).share, 1, 1e-6);
    // From far off cells are a few hundredths of a pixel, some thinner than is drawn, or a few thousandths.
    const Caught far = caught_of_sea(Event::transmission, 40, 160);
    EXPECT_NEAR(far.share, 1, 1e-6);
    EXPECT_GT(far.widened, 100);
    EXPECT_LT(far.widened, 100000);
    const Caught farther = caught_of_sea(Event::transmission, 100, 80);
    // Sums of 16000 cells a pixel in float.
    EXPECT_NEAR(farther.share, 1, 1e-4);
    EXPECT_GT(farther.widened, 150000);
}

// One sinusoid under an overhead sun: the exact landing map X = x + (d + h) tan(delta) of rays refracted at a
// cos kx gives the mean of E over each strip of the floor.
constexpr double kAmplitude = 0.01, kLength = 0.5, kPatch = 3, kView = 1;
constexpr int kStrips = 200;
const double kWaveNumber = 2 * glm::pi<double>() / kLength;
/// Paraxial focus below a crest: n / ((n - 1) a k^2) = 2.54 m.
const double kFocus = kMeshIndex / ((kMeshIndex - 1) * kAmplitude * kWaveNumber * kWaveNumber);

std::vector<double> exact_strips(double depth) {
    constexpr int rays = 400000;
    const double strip = kView / kStrips;
    std::vector<double> flux(kStrips, 0);
    double previous = 0;
    for (int i = 0; i <= rays; ++i) {
        const double x = kPatch * (static_cast<double>(i) / rays - 0.5);
        const double height = kAmplitude * std::cos(kWaveNumber * x);
        const double tilt = std::atan(-kAmplitude * kWaveNumber * std::sin(kWaveNumber * x));
        const double landing = x + (depth + height) * std::tan(tilt - std::asin(std::sin(tilt) / kMeshIndex));
        if (i > 0) {
            const double low = std::min(landing, previous), high = std::max(landing, previous);
            const double carried = test::transmittance(std::abs(tilt) < 1e-4 ? 0 : tilt) * kPatch / rays;
            const int first = std::max(0, static_cast<int>(std::floor((low + 0.5 * kView) / strip)));
            const int last =
                std::min(kStrips - 1, static_cast<int>(std::floor((high + 0.5 * kView) / strip)));
            for (int k = first; k <= last; ++k) {
                const double left = k * strip - 0.5 * kView;
                const double overlap = std::min(high, left + strip) - std::max(low, left);
                flux[static_cast<std::size_t>(k)] +=
                    high > low ? carried * std::max(0.0, overlap) / (high - low) : carried;
            }
        }
        previous = landing;
    }
    for (double& value : flux) value /= strip;
    return flux;
}

/// L1 error of E over its mean, with so many rays across the patch.
double sinusoid_error(double depth, const std::vector<double>& exact, int resolution) {
    scene::FrameScene scene = test::water_scene({kPatch, 0.5});
    scene.state.water->absorption = {0, 0, 0};
    scene.state.lights = {test::sun(0)};
    scene.state.lights[0].irradiance = {1, 1, 1};
    scene.state.objects = {test::plane_object({0, -depth, 0}, 20)};
    scene.state.caustics.map.map_resolution = resolution;
    test::add_water(scene, {{kAmplitude, {kWaveNumber, 0}, 0}}, 3000, 4);
    test::look(scene, {kStrips, 8}, kView * 8 / kStrips, {0, -0.1, 0}, {0, -1, 0}, {0, 0, -1});
    const test::Plane floor{{0, -depth, 0}};
    const methods::LayerResult result = test::draw_mesh(scene, test::receivers_on(scene, floor, true));
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < result.irradiance.size(); ++i) {
        const double expected = exact[i % kStrips];
        error += std::abs(static_cast<double>(result.irradiance[i].g) - expected);
        sum += expected;
    }
    return error / sum;
}

TEST(CausticMesh, ErrorFallsWithTheSquareOfTheSpacing) {
    // Rays 31 to 3.9 mm apart, pixels of 5 mm.
    for (const double share : {0.5, 2.0}) {
        const double depth = share * kFocus;
        const std::vector<double> exact = exact_strips(depth);
        double errors[4];
        for (int level = 0; level < 4; ++level) {
            errors[level] = sinusoid_error(depth, exact, 96 << level);
            RecordProperty("relative_l1_" + std::to_string(96 << level), std::to_string(errors[level]));
            printf("depth %.1f D*, %4d rays across: relative L1 error %.5f\n", share, 96 << level,
                   errors[level]);
        }
        // Measured 2.9e-3, 5e-4, 6e-5, 2e-5 before the focus, 4.9e-2, 2.9e-3, 3e-4, 9e-5 behind it: at least
        // second order, also where there are folds.
        for (int level = 0; level + 1 < 3; ++level) EXPECT_LT(errors[level + 1], errors[level] / 4) << level;
        EXPECT_LT(errors[3], errors[2] / 2);
        EXPECT_LT(errors[2], share < 1 ? 1e-4 : 5e-4);
    }
}

TEST(CausticMesh, LightOfCellsWithoutAMeasureIsNamedLost) {
    const scene::FrameScene scene = flat_pool(20, 8, 16);
    const caustic_mesh::CellDrawing drawing(scene, true, 64);
    const glm::vec3 middle = glm::vec3(glm::dvec3(0, -1.5, 0) - scene.origin);
    caustic_mesh::LandedCell cell;
    cell.corner = {middle + glm::vec3(-0.1f, 0, -0.1f), middle + glm::vec3(0.1f, 0, -0.1f),
                   middle + glm::vec3(0.1f, 0, 0.1f), middle + glm::vec3(-0.1f, 0, 0.1f)};
    cell.flux = {4, 1, 1, 4};
    cell.power = {glm::vec3(3, 0, 0), glm::vec3(0, 3, 0), glm::vec3(3, 0, 0), glm::vec3(0, 0, 6)};
    cell.share = 0.5f;
    cell.normal = {0, 1, 0};
    cell.beam = {0, -1, 0};
    layout::MeshCell drawn;
    bool widened = false;
    EXPECT_NE(drawing.draw(cell, drawn, widened), caustic_mesh::Drawn::lost);
    cell.beam = {1, 0, 0};  // along the plane: no brightness, but flux
    EXPECT_EQ(drawing.draw(cell, drawn, widened), caustic_mesh::Drawn::lost);
    // Corners 0 and 2 in both triangles: (2 * 4 + 1 + 2 * 1 + 2 * 4) / 6 of powers' means, of half a cell.
    EXPECT_FLOAT_EQ(caustic_mesh::CellDrawing::carried(cell, false), 0.5f * 19 / 6);
    // A triangle's three corners alike, half the cell: (4 + 1 + 1) / 6.
    EXPECT_FLOAT_EQ(caustic_mesh::CellDrawing::carried(cell, true), 0.5f * 1);
}

}  // namespace
}  // namespace dapple
