// E of beams as means over parts of the picture, from beams made by the test.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "methods/draw_beams.h"
#include "methods/drawn_sheets.h"

namespace dapple {
namespace {

/// W that a picture's E brings to the floor, green.
double flux(const scene::FrameScene& scene, const methods::adaptive_beams::BeamSet& beams) {
    double sum = 0;
    for (int sample = 0; sample < scene.state.clip.samples; ++sample) {
        const test::Drawn drawn = test::draw(
            scene, {beams}, methods::adaptive_beams::VolumeKind::six_triangles,
            methods::adaptive_beams::Shading::exact, std::numeric_limits<std::uint64_t>::max(), sample);
        for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
            const glm::dvec3 u(drawn.receivers.footprint_u[i]), v(drawn.receivers.footprint_v[i]);
            sum += static_cast<double>(drawn.sums.irradiance[i].g) * glm::length(glm::cross(u, v));
        }
    }
    return sum / scene.state.clip.samples;
}

scene::FrameScene lens_scene(double depth, glm::dvec3 from) {
    scene::FrameScene scene = test::flat_scene(0, 4);
    scene.state.water->absorption = scene.state.water->scattering = glm::dvec3(0);
    scene.state.objects[0] = test::level_plane("floor", -depth, 100);
    scene.state.camera.projection = scene::Projection::orthographic;
    scene.state.camera.up = from.x == 0 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
    // Borders of pixels pass the lens's axis at a distance.
    const glm::dvec3 middle(0.0023, -depth, 0.0037);
    scene.state.camera.position = middle + from;
    scene.state.camera.target = middle;
    scene.state.camera.view_height = 0.5;
    return scene;
}

TEST(BeamSurface, PicturesOfAnySizeHoldAllFlux) {
    // All of the lens's 32 W, in a point and in a line of the floor and behind these. Triangles that are
    // drawn as a fiftieth of a cell are summed up to 5e-4 of their flux, in float.
    double worst = 0;
    for (const double depth : {1.0, 1.2})
        for (const float across : {1.0f, 0.5f})
            for (const glm::dvec3 from : {glm::dvec3(0, 0.1, 0), glm::dvec3(0.25, 0.2, 0.1)})
                for (const glm::ivec3 size :
                     {glm::ivec3(1, 1, 1), glm::ivec3(2, 3, 1), glm::ivec3(64, 64, 1), glm::ivec3(2, 2, 4)}) {
                    if (size.z > 1 && (from.x == 0 || across < 1)) continue;
                    scene::FrameScene scene = lens_scene(depth, from);
                    scene.state.clip.width = size.x;
                    scene.state.clip.height = size.y;
                    scene.state.clip.samples = size.z;
                    const double sum = flux(scene, test::lens_of_beams(across, 0, static_cast<float>(depth)));
                    EXPECT_NEAR(sum, 32, 1e-3 * 32) << depth << " m, across " << across << ", from " << from.x
                                                    << ", " << size.x << " x " << size.y << " x " << size.z;
                    worst = std::max(worst, std::abs(sum / 32 - 1));
                }
    printf("flux of a lens in pictures of 1 to 4096 cells: off by %.1e\n", worst);
}

TEST(BeamSurface, SteepFloorsThroughAFocusHaveNoSpikes) {
    // Triangles of beams reach there from one side of the line 1 m deep that all rays meet to the other,
    // where the eight of a row of the lens lie over each other, each of 1 W.
    for (const double tilt : {45.0, 60.0, 75.0}) {
        scene::FrameScene scene = lens_scene(1, {0, 0.05, 0});
        const double angle = glm::radians(tilt);
        const glm::dvec3 normal(0, std::cos(angle), std::sin(angle)), middle(0, -1, 0.0117);
        scene.state.objects[0].transform.rotation = {angle, 0, 0};
        scene.state.objects[0].transform.position = middle;
        scene.state.camera.position = middle + 0.05 * normal;
        scene.state.camera.target = middle;
        scene.state.camera.up = {1, 0, 0};
        scene.state.clip.width = scene.state.clip.height = 256;
        methods::adaptive_beams::BeamSet lens = test::lens_of_beams(0.5f);
        std::vector<glm::dvec3> landed;
        for (auto& ray : lens.vertices) {
            const glm::dvec3 start(ray.a, 0, ray.b), way(ray.slope_a, -1, ray.slope_b);
            const double end = glm::dot(normal, middle - start) / glm::dot(normal, way);
            ray.end = static_cast<float>(end);
            landed.push_back(start + end * way);
            scene.state.camera.view_height =
                std::max(scene.state.camera.view_height, 2.1 * glm::distance(landed.back(), middle));
        }
        double least = 1;
        for (const glm::uvec3& t : lens.triangles)
            least = std::min(
                least, 0.5 * glm::length(glm::cross(landed[t.y] - landed[t.x], landed[t.z] - landed[t.x])));
        const test::Drawn drawn = test::draw(scene, {lens});
        double brightest = 0, sum = 0;
        for (const glm::vec3& e : drawn.sums.irradiance) {
            brightest = std::max(brightest, static_cast<double>(e.g));
            sum += static_cast<double>(e.g);
        }
        const double flux = sum * std::pow(scene.state.camera.view_height / 256, 2);
        printf("%g deg: %.3g W/m^2, a beam %.3g at most; %.3f of 32 W\n", tilt, brightest, 1 / least, flux);
        EXPECT_LT(brightest, 8 / least);
        // Those that reach over the line are in the rings of corners on both sides of it.
        EXPECT_GT(flux, 32);
        EXPECT_LT(flux, 1.3 * 32);
    }
}

TEST(BeamSurface, APointOfLightIsInItsPixel) {
    scene::FrameScene scene = lens_scene(1, {0, 0.1, 0});
    scene.state.clip.width = scene.state.clip.height = 33;
    const test::Drawn drawn = test::draw(scene, {test::lens_of_beams(1, 0, 1)});
    const double cell = std::pow(0.5 / 33, 2);
    for (std::size_t i = 0; i < drawn.receivers.pixels(); ++i) {
        const glm::dvec3 p(drawn.receivers.position[i]);
        const bool holds = std::max(std::abs(p.x), std::abs(p.z)) < 0.5 * 0.5 / 33;
        EXPECT_NEAR(drawn.sums.irradiance[i].g * cell, holds ? 32 : 0, 1e-3 * 32) << p.x << ' ' << p.z;
    }
}

}  // namespace
}  // namespace dapple
