#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "light/water_beams.h"
#include "light/water_grids.h"

/// What the tests of beams on the water mesh ask of them.
namespace dapple::test {

using light::BeamSheet;
using light::Chain;
using light::Event;

inline constexpr double kIndex = 1.333;

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
        sum += sheet.losses.absorbed + sheet.losses.wave_shadow + sheet.losses.total_reflection +
               sheet.losses.outside_cone + sheet.losses.not_finite;
    return sum;
}

/// Reflectance by angles, written apart from the program's vector forms.
inline double reflectance(double zenith, double n) {
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

/// Light that the triangles meet which face it: m^2 for a sun.
inline double met_by_sun(const scene::FrameScene& scene) {
    double met = 0;
    for (const glm::uvec3 t : scene.water->mesh.triangles) {
        const auto& p = scene.water->mesh.positions;
        const double one =
            -0.5 * glm::dot(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]), scene.state.lights[0].direction);
        if (one > 0) met += one;
    }
    return met;
}

template <class Real>
void expect_sound(const std::vector<BeamSheet<Real>>& sheets) {
    for (const auto& sheet : sheets) {
        for (std::size_t v = 0; v < sheet.rays.size(); ++v) {
            const auto& ray = sheet.rays[v];
            ASSERT_TRUE(std::isfinite(ray.a) && std::isfinite(ray.b) && std::isfinite(ray.slope_a) &&
                        std::isfinite(ray.slope_b) && std::isfinite(sheet.start[v]));
            // dot(direction, axis) > 0.1 is a slope below sqrt(99); a float's rounding of it.
            ASSERT_LT(std::hypot(ray.slope_a, ray.slope_b), std::sqrt(99.0) * (1 + 1e-6));
        }
        for (const Real f : sheet.flux) ASSERT_TRUE(f >= 0 && std::isfinite(f));
    }
}

}  // namespace dapple::test
