#include "light/water_beams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "light/water_grids.h"

namespace dapple {
namespace {

using light::BeamSheet;
using light::Chain;
using light::Event;

constexpr double kIndex = 1.333;

template <class Real>
std::vector<BeamSheet<Real>> beams(const scene::FrameScene& scene, Event event, int sun_samples = 1) {
    const rays::RayScene rays(scene);
    FrameStats stats;
    return light::water_beams<Real>(scene, rays, Chain{0, event}, sun_samples, stats);
}

template <class Real>
double flux(const std::vector<BeamSheet<Real>>& sheets) {
    double sum = 0;
    for (const auto& sheet : sheets) sum = std::accumulate(sheet.flux.begin(), sheet.flux.end(), sum);
    return sum;
}

/// What the chain's beams carry and what it lost, with the second crossings that its beams still carry left
/// out.
template <class Real>
double flux_and_losses(const std::vector<BeamSheet<Real>>& sheets) {
    double sum = flux(sheets);
    for (const auto& sheet : sheets)
        sum += sheet.losses.wave_shadow + sheet.losses.total_reflection + sheet.losses.outside_cone +
               sheet.losses.not_finite;
    return sum;
}

/// Reflectance by angles, written apart from the program's vector forms.
double reflectance(double zenith, double n) {
    if (zenith == 0) return std::pow((n - 1) / (n + 1), 2);
    const double t = std::asin(std::sin(zenith) / n);
    const double s = std::sin(zenith - t) / std::sin(zenith + t),
                 p = std::tan(zenith - t) / std::tan(zenith + t);
    return 0.5 * (s * s + p * p);
}

template <class Real>
glm::dvec3 direction(const BeamSheet<Real>& sheet, std::size_t v) {
    return glm::normalize(sheet.world_from_mesh *
                          glm::dvec3(sheet.rays[v].slope_a, sheet.rays[v].slope_b, 1));
}

/// World position where ray v leaves the water.
template <class Real>
glm::dvec3 foot(const scene::FrameScene& scene, const BeamSheet<Real>& sheet, std::size_t v) {
    const glm::dvec4 r(sheet.rays[v].a, sheet.rays[v].b, sheet.rays[v].slope_a, sheet.rays[v].slope_b);
    const double depth = static_cast<double>(sheet.start[v]);
    return scene.origin + sheet.world_from_mesh * glm::dvec3(r.x + depth * r.z, r.y + depth * r.w, depth);
}

template <class Real>
void expect_flat_water(double tolerance) {
    for (const double zenith : {0.0, 30.0, 60.0, 80.0, 89.0}) {
        SCOPED_TRACE(zenith);
        scene::FrameScene scene = test::water_scene({7, 3}, {1.3, -2.1});
        scene.origin = {2, -3, 5};
        scene.state.lights = {test::sun(zenith)};
        scene.state.lights[0].irradiance = {3, 2, 1};
        test::add_water(scene, {}, 40, 20);
        const double i = glm::radians(zenith), t = std::asin(std::sin(i) / kIndex),
                     r = reflectance(i, kIndex);
        const glm::dvec2 heading(-std::cos(glm::radians(20.0)), -std::sin(glm::radians(20.0)));
        for (const Event event : {Event::transmission, Event::reflection}) {
            const auto sheets = beams<Real>(scene, event);
            ASSERT_EQ(sheets.size(), 1u);
            const BeamSheet<Real>& sheet = sheets[0];
            const bool transmission = event == Event::transmission;
            const double out = transmission ? t : i;
            const glm::dvec3 expected(heading.x * std::sin(out), std::cos(out) * (transmission ? -1 : 1),
                                      heading.y * std::sin(out));
            EXPECT_EQ(sheet.rows, 21);
            EXPECT_EQ(sheet.columns, 41);
            EXPECT_EQ(sheet.color, glm::dvec3(3, 2, 1));
            EXPECT_EQ(sheet.in_water(), transmission);
            EXPECT_NEAR(glm::determinant(sheet.world_from_mesh), 1, 1e-14);
            EXPECT_NEAR(glm::length(sheet.world_from_mesh[2] - expected), 0, 1e-14);
            ASSERT_EQ(sheet.flux.size(), scene.water->mesh.triangles.size());
            for (std::size_t v = 0; v < sheet.rays.size(); ++v) {
                ASSERT_EQ(sheet.valid[v], 1);
                ASSERT_NEAR(glm::length(direction(sheet, v) - expected), 0, tolerance);
                // Ten metres from the origin: so much more round-off.
                ASSERT_NEAR(glm::length(foot(scene, sheet, v) - scene.water->mesh.positions[v]), 0,
                            10 * tolerance);
            }
            EXPECT_NEAR(flux(sheets) / (21 * std::cos(i) * (transmission ? 1 - r : r)), 1, tolerance);
            EXPECT_EQ(sheet.losses.wave_shadow, 0);
            EXPECT_EQ(sheet.losses.second_crossing, 0);
        }
    }
}

// Round-off of a few operations; at 89 degrees cos(i) = 0.017 by std::cos has 6e-15 of its own.
TEST(WaterBeams, FlatWaterFollowsSnellAndFresnelInDouble) {
    expect_flat_water<double>(2e-13);
}
TEST(WaterBeams, FlatWaterFollowsSnellAndFresnelInFloat) {
    expect_flat_water<float>(2e-7);
}

TEST(WaterBeams, TransmittedAndReflectedFluxSumToWhatMeetsAWavySea) {
    scene::FrameScene scene = test::water_scene({6, 6});
    scene.state.lights = {test::sun(40)};
    test::add_water(scene, test::gentle_sea(), 100, 100);
    const double sum =
        flux(beams<double>(scene, Event::transmission)) + flux(beams<double>(scene, Event::reflection));
    double met = 0;
    for (const glm::uvec3 t : scene.water->mesh.triangles) {
        const auto& p = scene.water->mesh.positions;
        met -= 0.5 * glm::dot(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]), scene.state.lights[0].direction);
    }
    EXPECT_NEAR(sum / met, 1, 1e-12);  // 2e4 triangles, round-off of the sum
}

}  // namespace
}  // namespace dapple
