// Sliced beams under flat water in double: level, upright and sloped receivers, sun and lamp.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "ocean/grid_size.h"
#include "ocean/lamp_mesh.h"

namespace dapple {
namespace {

using light::Event;
using test::SheetSet;

constexpr double kIndex = 1.333;

class BeamsFlat : public testing::TestWithParam<double> {
protected:
    double zenith() const { return glm::radians(GetParam()); }
    /// Direction of the refracted sun of sun_from_zenith.
    glm::dvec3 refracted() const {
        const double t = std::asin(std::sin(zenith()) / kIndex);
        return {std::sin(t), -std::cos(t), 0};
    }
};
INSTANTIATE_TEST_SUITE_P(SunFromZenith, BeamsFlat, testing::Values(0.0, 30.0, 60.0, 80.0, 89.0),
                         [](const auto& sun) { return std::to_string(static_cast<int>(sun.param)) + "deg"; });

TEST_P(BeamsFlat, ALevelFloorHasTheClosedForm) {
    scene::FrameScene scene = test::scene_of_flat_water({6, 5}, 61, 47);
    scene.state.lights = {test::sun_from_zenith(GetParam())};
    scene.state.water->absorption = {0.4, 0.1, 0.03};
    const SheetSet<double> sheets(scene, Event::transmission, 10);
    double worst = 0;
    for (const double depth : {0.5, 2.0}) {
        const test::FlatFloor floor = test::flat_floor(GetParam(), depth, kIndex);
        const glm::dvec3 expected = scene.state.lights[0].irradiance * floor.irradiance *
                                    glm::exp(-scene.state.water->absorption * floor.way);
        const double shift = depth * refracted().x / -refracted().y;
        std::vector<test::SheetSet<double>::Receiver> receivers;
        // Smaller, like and much larger than beams (0.1 m), about the middle of the lit part.
        for (const double size : {0.003, 0.11, 1.7})
            for (int row = 0; row < 7; ++row)
                for (int column = 0; column < 8; ++column)
                    receivers.push_back(
                        test::receiver<double>({shift + 0.037 * column - 0.14, -depth, 0.041 * row - 0.12},
                                               {0, 1, 0}, {size, 0.7 * size}));
        for (const glm::dvec3 value : sheets.irradiance(receivers))
            for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(value[c] / expected[c] - 1));
    }
    RecordProperty("worst", std::to_string(worst));
    printf("sun %2.0f deg from the zenith: E off by %.1e in the worst of 360 receivers\n", GetParam(), worst);
    EXPECT_LT(worst, 1e-9);
}

TEST_P(BeamsFlat, WallsAndSlopesCatchByTheirCosine) {
    scene::FrameScene scene = test::scene_of_flat_water({6, 5}, 61, 47);
    scene.state.lights = {test::sun_from_zenith(GetParam())};
    const SheetSet<double> sheets(scene, Event::transmission, 10);
    // Across a ray: the flux of a unit of level floor over the cosine there.
    const glm::dvec3 across_ray = scene.state.lights[0].irradiance *
                                  test::flat_floor(GetParam(), 1, kIndex).irradiance / -refracted().y;
    double worst = 0;
    int dark = 0;
    for (const glm::dvec3 turned : {glm::dvec3(-1, 0, 0),
                                    {1, 0, 0},
                                    {0, 0, 1},
                                    {-1, 1, 0.3},
                                    {0.4, 1, -0.6},
                                    {-1, 0.02, 0},
                                    {1, 1.2, 1},
                                    {-1, -1, 0}}) {
        const glm::dvec3 normal = glm::normalize(turned);
        const double cosine = -glm::dot(refracted(), normal);
        for (const double depth : {0.6, 1.9}) {
            const glm::dvec3 centre(depth * refracted().x / -refracted().y, -depth, 0.1);
            for (const double size : {0.004, 0.13, 0.5}) {
                const glm::dvec3 value =
                    sheets.irradiance(test::receiver<double>(centre, normal, {size, 0.6 * size}));
                if (cosine <= 1e-12) {  // lit from behind, or along its plane
                    EXPECT_EQ(value, glm::dvec3(0));
                    ++dark;
                } else {
                    for (int c = 0; c < 3; ++c)
                        worst = std::max(worst, std::abs(value[c] / (across_ray[c] * cosine) - 1));
                }
            }
        }
    }
    printf("sun %2.0f deg from the zenith: walls and slopes off by %.1e, %d receivers dark\n", GetParam(),
           worst, dark);
    EXPECT_LT(worst, 1e-9);
    EXPECT_GT(dark, 0);
}

TEST_P(BeamsFlat, TheMirroredSunLightsCeilingsAndWalls) {
    scene::FrameScene scene = test::scene_of_flat_water({6, 5}, 61, 47);
    scene.state.lights = {test::sun_from_zenith(GetParam())};
    const SheetSet<double> sheets(scene, Event::reflection, 10);
    const glm::dvec3 mirrored = scene.state.lights[0].direction * glm::dvec3(1, -1, 1);
    const glm::dvec3 across_ray = scene.state.lights[0].irradiance *
                                  (1 - test::flat_floor(GetParam(), 1, kIndex).irradiance / mirrored.y);
    for (const glm::dvec3 turned : {glm::dvec3(0, -1, 0), {-1, 0, 0}, {-1, -1, 0.2}}) {
        const glm::dvec3 normal = glm::normalize(turned);
        const double cosine = -glm::dot(mirrored, normal);
        const double way = GetParam() > 85 ? 0.8 : 0.5 / mirrored.y;
        const glm::dvec3 centre = way * mirrored + glm::dvec3(0.02, 0, 0.01);
        if (cosine < 1e-12) continue;
        for (const double size : {0.004, 0.02}) {
            const glm::dvec3 value =
                sheets.irradiance(test::receiver<double>(centre, normal, {size, 0.6 * size}));
            // 1 - T loses a digit against T: R is 0.02 from above.
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c] / (across_ray[c] * cosine), 1, 1e-9) << size;
        }
    }
}

TEST(BeamsWaveBand, ALevelReceiverAmongTheWavesIsLitUnderCrestsOnly) {
    // h = a cos(kx), overhead sun, receivers on the rest plane: rays leave the water above it only where
    // h > 0, and then land at x + h tan(delta).
    constexpr double a = 0.02, wave = 2 * glm::pi<double>() / 0.5, pixel = 0.01;
    scene::FrameScene scene = test::scene_of_water({2, 1}, 2000, 1, [](double x, double) {
        return a * glm::dvec3(std::cos(wave * x), -wave * std::sin(wave * x), 0);
    });
    scene.state.lights = {test::sun_from_zenith(0)};
    scene.state.lights[0].irradiance = {1, 1, 1};
    const SheetSet<double> sheets(scene, Event::transmission, 1);
    std::vector<SheetSet<double>::Receiver> receivers;
    for (int i = 0; i < 100; ++i)
        receivers.push_back(test::receiver<double>({pixel * (i + 0.5) - 0.5, 0, 0}, {0, 1, 0}, {pixel, 0.3}));
    const std::vector<glm::dvec3> landed = sheets.irradiance(receivers);
    // Exact rays, 1 um apart: each brings its flux to where it lands.
    std::vector<double> exact(100, 0);
    constexpr int rays = 2000000;
    for (int i = 0; i < rays; ++i) {
        const double x = 2 * ((i + 0.5) / rays - 0.5), height = a * std::cos(wave * x);
        if (height <= 0) continue;
        const double tilt = std::atan(-a * wave * std::sin(wave * x));
        const double inside = std::asin(std::sin(tilt) / kIndex);
        const double s = std::sin(tilt - inside) / std::sin(tilt + inside),
                     p = std::tan(tilt - inside) / std::tan(tilt + inside);
        const double transmittance =
            std::abs(tilt) > 1e-4 ? 1 - 0.5 * (s * s + p * p) : 4 * kIndex / std::pow(kIndex + 1, 2);
        const double column = (x + height * std::tan(tilt - inside) + 0.5) / pixel;
        if (column >= 0 && column < 100)
            exact[static_cast<std::size_t>(column)] += transmittance * 2 / rays / pixel;
    }
    double error = 0, sum = 0;
    int dark = 0;
    for (std::size_t i = 0; i < 100; ++i) {
        error += std::abs(landed[i].x - exact[i]);
        sum += exact[i];
        if (exact[i] == 0) {
            EXPECT_EQ(landed[i].x, 0) << i;
            ++dark;
        }
    }
    printf("among the waves: relative L1 error %.1e, %d of 100 pixels dark\n", error / sum, dark);
    // The rays' grain is 1e-4 of a pixel, the mesh's error (k cell)^2 / 8 = 2e-5.
    EXPECT_LT(error / sum, 3e-4);
    EXPECT_GT(dark, 30);
    EXPECT_LT(dark, 55);
}

/// E of a level receiver `beyond` m behind flat water, r m from the axis of a lamp of unit intensity `before`
/// m in front of it, where the refractive index is 1 / n of that behind: the cone of rays within the angle i,
/// per area of the ring on which it lands. `absorption`: /m, in front of the water.
double lamp_irradiance(double r, double before, double beyond, double n = kIndex, double absorption = 0) {
    // sin(i) by bisection: r grows with i.
    double low = 0, high = std::min(1.0, n);
    for (int step = 0; step < 60; ++step) {
        const double s = 0.5 * (low + high), st = s / n;
        const double lands = before * s / std::sqrt(1 - s * s) + beyond * st / std::sqrt(1 - st * st);
        (lands < r ? low : high) = s;
    }
    const double s = 0.5 * (low + high), c = std::sqrt(1 - s * s), st = s / n, ct = std::sqrt(1 - st * st);
    const double rs = (c - n * ct) / (c + n * ct), rp = (n * c - ct) / (n * c + ct);
    const double transmittance = 1 - 0.5 * (rs * rs + rp * rp);
    const double stretch = before / (c * c) + beyond * c / (n * ct * ct * ct);
    const double ring = before / c + beyond / (n * ct);  // r / sin(i)
    return transmittance * std::exp(-absorption * before / c) / (ring * stretch);
}

TEST(BeamsFlatLamp, OnTheAxisTheClosedFormIsTheSimpleOne) {
    const double expected = 4 * kIndex / std::pow(kIndex + 1, 2) / std::pow(1.5 + 2 / kIndex, 2);
    EXPECT_NEAR(lamp_irradiance(1e-6, 1.5, 2), expected, 1e-9 * expected);
}

TEST(BeamsFlatLamp, PixelMeansConvergeWithOrderTwo) {
    constexpr double above = 1.5, below = 2;
    // Pixels larger than the coarsest beams (which land 0.17 m wide), anywhere, so that their edges cut beams
    // in all ways: how they do is what makes the error of a single pixel jump about its order.
    std::vector<SheetSet<double>::Receiver> receivers;
    std::vector<double> exact;
    // Gauss & Legendre's four points: E changes by some per cent over a pixel, so right to 1e-10.
    const double nodes[] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    const double weights[] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-1, 1), width(0.2, 0.3);
    for (int k = 0; k < 1000; ++k) {
        const glm::dvec2 at(place(random), place(random)), size(width(random), width(random));
        receivers.push_back(test::receiver<double>({at.x, -below, at.y}, {0, 1, 0}, size));
        double mean = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                mean += 0.25 * weights[i] * weights[j] *
                        lamp_irradiance(glm::length(at + 0.5 * size * glm::dvec2(nodes[i], nodes[j])), above,
                                        below);
        exact.push_back(mean);
    }
    std::vector<double> errors;
    for (const int cells : {32, 64, 128, 256}) {
        scene::FrameScene scene = test::scene_of_flat_water({2.6, 2.6}, cells, cells);
        scene::Light lamp;
        lamp.name = "lamp";
        lamp.type = scene::LightType::point;
        lamp.position = {0, above, 0};
        lamp.intensity = {1, 1, 1};
        scene.state.lights = {lamp};
        const auto values = SheetSet<double>(scene, Event::transmission, 3).irradiance(receivers);
        double error = 0, sum = 0;
        for (std::size_t i = 0; i < exact.size(); ++i) {
            error += std::abs(values[i].x - exact[i]);
            sum += exact[i];
        }
        errors.push_back(error / sum);
        printf("beams %.4f m wide: relative L1 error %.2e%s\n", 2.6 / cells, errors.back(),
               errors.size() < 2
                   ? ""
                   : (", order " + std::to_string(std::log2(errors[errors.size() - 2] / errors.back())))
                         .c_str());
    }
    // Over the last two halvings.
    EXPECT_NEAR(std::log2(errors[1] / errors[3]) / 2, 2, 0.1);
    EXPECT_LT(errors[3], 2e-5);  // measured 1.0e-5
}

TEST(BeamsFlatLamp, TheDefaultMeshServesALampPixelByPixel) {
    constexpr double above = 2, below = 1.5;
    scene::FrameState state;
    state.water.emplace().extent.size = {8, 8};
    scene::Light& lamp = state.lights.emplace_back();
    lamp.type = scene::LightType::point;
    lamp.position = {0, above, 0};
    lamp.intensity = {1, 1, 1};
    const int cells = ocean::grid_size(*ocean::with_mesh_for_lamps(state).water).cells_x;
    scene::FrameScene scene = test::scene_of_flat_water({8, 8}, cells, cells);
    scene.state.lights = state.lights;
    std::vector<SheetSet<double>::Receiver> receivers;
    std::vector<double> exact;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-1.5, 1.5);
    for (int k = 0; k < 1000; ++k) {
        const glm::dvec2 at(place(random), place(random));
        receivers.push_back(test::receiver<double>({at.x, -below, at.y}, {0, 1, 0}, {0.01, 0.01}));
        exact.push_back(lamp_irradiance(glm::length(at), above, below));
    }
    const auto values = SheetSet<double>(scene, Event::transmission, 3).irradiance(receivers);
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        error += std::abs(values[i].x - exact[i]);
        sum += exact[i];
    }
    printf("%d cells across 8 m, a lamp 2 m above them: relative L1 error %.2e\n", cells, error / sum);
    // Each beam is as bright as its mean: 0.13 of a cell over the lamp's height, measured; 0.41 with two
    // cells.
    EXPECT_LT(error / sum, 0.007);
}

TEST(BeamsFlatLamp, WaterAbsorbsBeforeItsSurfaceToo) {
    constexpr double deep = 1.2, above = 0.9, floor = 1.8;
    scene::FrameScene scene = test::scene_of_flat_water({3.2, 3.2}, 320, 320);
    scene::Light lamp;
    lamp.name = "lamp";
    lamp.type = scene::LightType::point;
    lamp.position = {0, -deep, 0};
    lamp.intensity = {3, 2, 1};
    scene.state.lights = {lamp};
    scene.state.water->absorption = {0.4, 0.1, 0.03};
    const SheetSet<double> through(scene, Event::transmission, 3), mirrored(scene, Event::reflection, 3);
    // Across some ten beams; E is quadratic over a receiver, and its mean E's at the middle, but for 1e-3.
    constexpr double size = 0.1;
    for (const double r : {0.0, 0.25, 0.5, 0.75}) {
        const glm::dvec3 ceiling =
            through.irradiance(test::receiver<double>({0.6 * r, above, 0.8 * r}, {0, -1, 0}, {size, size}));
        const glm::dvec3 bottom =
            mirrored.irradiance(test::receiver<double>({0.6 * r, -floor, 0.8 * r}, {0, 1, 0}, {size, size}));
        // The mirrored lamp: all of its way, to the surface and back, is in the water.
        const double way = std::hypot(r, deep + floor), c = (deep + floor) / way,
                     ct = std::sqrt(1 - kIndex * kIndex * (1 - c * c)),
                     rs = (kIndex * c - ct) / (kIndex * c + ct), rp = (c - kIndex * ct) / (c + kIndex * ct),
                     reflectance = 0.5 * (rs * rs + rp * rp);
        for (int channel = 0; channel < 3; ++channel) {
            const double k = scene.state.water->absorption[channel], intensity = lamp.intensity[channel];
            EXPECT_NEAR(ceiling[channel] / (intensity * lamp_irradiance(r, deep, above, 1 / kIndex, k)), 1,
                        2e-3)
                << r;
            EXPECT_NEAR(bottom[channel] / (intensity * reflectance * c / (way * way) * std::exp(-k * way)), 1,
                        2e-3)
                << r;
        }
    }
}

}  // namespace
}  // namespace dapple
