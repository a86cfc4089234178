// What beams of light in absorbing water carry through level planes below a sea, against single rays in
// double over the same sea; below flat water against the closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "base/parallel.h"
#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

using light::Event;
using test::SheetSet;

constexpr double kIndex = 1.333;
constexpr double kPi = glm::pi<double>();
constexpr double kDepths[] = {0.5, 1.5, 3.0};  ///< m

/// Height and slopes of waves that repeat every 2 m in x and in z: rms slope 0.083.
glm::dvec3 sea(double x, double z) {
    struct Wave {
        double kx, kz;  ///< 1/m
        double amplitude, phase;
    };
    static constexpr Wave kWaves[] = {
        {kPi, 2 * kPi, 0.008, 0.3}, {4 * kPi, -kPi, 0.006, 1.9}, {-2 * kPi, -3 * kPi, 0.006, 4.1}};
    glm::dvec3 h(0);
    for (const Wave& wave : kWaves) {
        const double phase = wave.kx * x + wave.kz * z + wave.phase;
        h += wave.amplitude *
             glm::dvec3(std::cos(phase), -wave.kx * std::sin(phase), -wave.kz * std::sin(phase));
    }
    return h;
}

/// (exp(-a) - exp(-b)) / (b - a), exact also where they are close.
double decay_between(double a, double b) {
    const double half = 0.5 * (b - a);
    return std::exp(-0.5 * (a + b)) * (std::abs(half) < 1e-3 ? 1 + half * half / 6 : std::sinh(half) / half);
}

/// Mean of exp(-d) over a triangle with d linear between its corners: twice the divided difference of exp at
/// -a, -b, -c; where they are too close for it, from the first three moments of d.
double mean_left(double a, double b, double c) {
    if (a > b) std::swap(a, b);
    if (b > c) std::swap(b, c);
    if (a > b) std::swap(a, b);
    if (c - a > 1e-2) return 2 * (decay_between(a, b) - decay_between(b, c)) / (c - a);
    const double m = (a + b + c) / 3;
    const double u = a - m, v = b - m, w = c - m;
    const double second = (u * u + v * v + w * w) / 12, third = (u * u * u + v * v * v + w * w * w) / 30;
    return std::exp(-m) * (1 + 0.5 * second - third / 6);
}

/// Flux of all beams through a level plane: of each the mean, over its triangle, of what the refracted ways
/// to the plane leave over.
glm::dvec3 through_plane(const scene::FrameScene& scene, const light::BeamSheet<double>& sheet,
                         double depth) {
    const glm::dvec3 extinction = scene.state.water->extinction();
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
        if (!(sheet.flux[i] > 0)) continue;
        double way[3];
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t corner = scene.water->mesh.triangles[i][k];
            const auto& ray = sheet.rays[corner];
            const glm::dvec3 direction =
                glm::normalize(sheet.world_from_mesh * glm::dvec3(ray.slope_a, ray.slope_b, 1));
            way[k] = (depth + scene.water->mesh.positions[corner].y) / -direction.y;
        }
        for (int c = 0; c < 3; ++c)
            sum[c] += sheet.power(i)[c] *
                      mean_left(extinction[c] * way[0], extinction[c] * way[1], extinction[c] * way[2]);
    }
    return sum;
}

/// What single rays carry there from `size` m squared of water, by `across` squared of them and physics of
/// their own: a sum over whole periods of a smooth function, which converges faster than any power.
glm::dvec3 by_rays(const scene::FrameScene& scene, double size, int across, double depth) {
    const glm::dvec3 sun = scene.state.lights[0].direction;
    const glm::dvec3 extinction = scene.state.water->extinction();
    std::vector<glm::dvec3> rows(static_cast<std::size_t>(across), glm::dvec3(0));
    parallel_for(rows.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            for (int column = 0; column < across; ++column) {
                const glm::dvec3 h =
                    sea(size * (column + 0.5) / across, size * (static_cast<double>(row) + 0.5) / across);
                // Area times cosine, a m^2 of the rest plane.
                const glm::dvec3 facing(-h.y, 1, -h.z), normal = glm::normalize(facing);
                const double cos_i = -glm::dot(sun, normal), i = std::acos(cos_i),
                             t = std::asin(std::sin(i) / kIndex);
                const double s = std::sin(i - t) / std::sin(i + t), p = std::tan(i - t) / std::tan(i + t);
                const double passed = -glm::dot(sun, facing) * (1 - 0.5 * (s * s + p * p));
                const glm::dvec3 along = glm::normalize(sun + cos_i * normal);
                const glm::dvec3 way = std::sin(t) * along - std::cos(t) * normal;
                rows[row] += passed * glm::exp(-extinction * (depth + h.x) / -way.y);
            }
        }
    });
    glm::dvec3 sum(0);
    for (const glm::dvec3& row : rows) sum += row;
    return sum * (size * size / (static_cast<double>(across) * across)) * scene.state.lights[0].irradiance;
}

double worst_channel(const glm::dvec3& found, const glm::dvec3& expected) {
    const glm::dvec3 off = glm::abs(found / expected - 1.0);
    return std::max({off.x, off.y, off.z});
}

scene::FrameScene murky(scene::FrameScene scene, double zenith) {
    scene.state.lights = {test::sun_from_zenith(zenith)};
    scene.state.water->absorption = {0.5, 0.15, 0.03};
    scene.state.water->scattering = {0.2, 0.1, 0.05};
    return scene;
}

class BeamFlux : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, BeamFlux, testing::Values(0.0, 35.0, 60.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(BeamFlux, BelowFlatWaterHasTheClosedForm) {
    const scene::FrameScene scene = murky(test::scene_of_flat_water({2, 3}, 7, 9), GetParam());
    const SheetSet<double> set(scene, Event::transmission, 4);
    for (const double depth : kDepths) {
        const test::FlatFloor floor = test::flat_floor(GetParam(), depth, kIndex);
        const glm::dvec3 expected = 6 * floor.irradiance * scene.state.lights[0].irradiance *
                                    glm::exp(-scene.state.water->extinction() * floor.way);
        EXPECT_LT(worst_channel(through_plane(scene, set.sheets()[0]->sheet(), depth), expected), 1e-12);
    }
}

TEST_P(BeamFlux, ThroughPlanesBelowASeaIsThatOfSingleRays) {
    // 48 cells a wave of 0.485 m, over one period.
    constexpr double kSize = 2;
    constexpr int kCells = 198;
    const scene::FrameScene scene =
        murky(test::scene_of_water({kSize, kSize}, kCells, kCells, sea), GetParam());
    const SheetSet<double> set(scene, Event::transmission, 4);
    ASSERT_EQ(set.sheets().size(), 1u);
    const light::BeamSheet<double>& sheet = set.sheets()[0]->sheet();
    for (const double depth : kDepths) {
        const glm::dvec3 exact = by_rays(scene, kSize, 512, depth);
        EXPECT_LT(worst_channel(by_rays(scene, kSize, 256, depth), exact), 1e-9) << "too few rays";
        const double beams = worst_channel(through_plane(scene, sheet, depth), exact);
        // E of the method over a rectangle that all of the light lands on.
        const double e = worst_channel(
            20.0 * 20.0 * set.irradiance(test::receiver<double>({1, -depth, 0}, {0, 1, 0}, {20, 20})), exact);
        printf("sun %2.0f deg from the zenith, %.1f m deep: flux of beams off by %.1e, by E %.1e\n",
               GetParam(), depth, beams, e);
        EXPECT_LE(beams, 1e-4);
        EXPECT_LE(e, 1e-4);
    }
}

}  // namespace
}  // namespace dapple
