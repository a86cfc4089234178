// The sun's disc: what it does to a focal line, and that no light is lost by it.
#include <gtest/gtest.h>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "light/water_grids.h"

namespace dapple {
namespace {

using light::Event;
using test::SheetSet;

constexpr double kIndex = 1.333;
constexpr double kDepth = 2;
constexpr double kDiameter = 0.02;  // rad, some two suns

/// A cylinder lens: the cap of an ellipse of eccentricity 1 / n, whose lower focus is a line along z.
scene::FrameScene cylinder_lens(double diameter) {
    const double major = kDepth / (1 + 1 / kIndex), squeeze = 1 - 1 / (kIndex * kIndex);
    scene::FrameScene scene = test::scene_of_water({0.2, 2}, 100, 20, [&](double x, double) {
        const double y = std::sqrt(major * major - x * x / squeeze);
        return glm::dvec3(y - major, -x / (squeeze * y), 0);
    });
    scene.state.lights = {test::sun_from_zenith(0)};
    scene.state.lights[0].irradiance = {1, 1, 1};
    scene.state.lights[0].angular_diameter = diameter;
    return scene;
}

/// Flux across the focal line, shares of the whole in strips of kStrip m about it.
constexpr double kStrip = 2.5e-4;
constexpr int kStrips = 200;
std::vector<double> profile(int sun_samples) {
    const scene::FrameScene scene = cylinder_lens(kDiameter);
    const SheetSet<double> sheets(scene, Event::transmission, 4, sun_samples);
    EXPECT_EQ(sheets.sheets().size(), static_cast<std::size_t>(sun_samples));
    std::vector<SheetSet<double>::Receiver> strips;
    for (int i = 0; i < kStrips; ++i)
        strips.push_back(test::receiver<double>({kStrip * (i + 0.5 - 0.5 * kStrips), -kDepth, 0}, {0, 1, 0},
                                                {kStrip, 0.1}));
    std::vector<double> flux;
    double sum = 0;
    for (const glm::dvec3 value : sheets.irradiance(strips)) {
        flux.push_back(value.x * kStrip);
        sum += flux.back();
    }
    // The line's light: what enters a metre of the lens.
    EXPECT_NEAR(sum / (sheets.power().x / 2), 1, 0.02) << "strips too few or too coarse";
    for (double& value : flux) value /= sum;
    return flux;
}

double variance(const std::vector<double>& profile) {
    double sum = 0;
    for (int i = 0; i < kStrips; ++i) {
        const double x = kStrip * (i + 0.5 - 0.5 * kStrips);
        sum += profile[static_cast<std::size_t>(i)] * x * x;
    }
    return sum;
}

TEST(BeamsDisc, AFocalLineGetsTheDiscsVarianceFromOneSheetAndFromMany) {
    // Near the axis a lens moves its focus by the depth over n times the light's tilt.
    const double radius = kDepth / kIndex * std::tan(0.5 * kDiameter);
    const double expected = 0.25 * radius * radius;  // of a disc along an axis
    const std::vector<double> one = profile(1), many = profile(64);
    std::vector<double> disc;
    for (int i = 0; i < kStrips; ++i) {
        const auto below = [&](double x) {  // share of a disc's area on one side of a chord
            const double s = std::clamp(x / radius, -1.0, 1.0);
            return 0.5 + (s * std::sqrt(1 - s * s) + std::asin(s)) / glm::pi<double>();
        };
        const double x = kStrip * (i - 0.5 * kStrips);
        disc.push_back(below(x + kStrip) - below(x));
    }
    const auto difference = [](const std::vector<double>& x, const std::vector<double>& y) {
        double sum = 0;
        for (std::size_t i = 0; i < x.size(); ++i) sum += std::abs(x[i] - y[i]);
        return sum;
    };
    printf("variance over the disc's: %.4f by one sheet, %.4f by 64\n", variance(one) / expected,
           variance(many) / expected);
    printf("L1 from the disc's profile: %.3f by one sheet, %.3f by 64; between them %.3f\n",
           difference(one, disc), difference(many, disc), difference(one, many));
    // A box of 26 mm sampled every 0.25 mm.
    EXPECT_NEAR(variance(one) / expected, 1, 0.03);
    // 64 points of a spiral, each widened by an ellipse of its part, for a disc.
    EXPECT_NEAR(variance(many) / expected, 1, 0.03);
    // A box of a half-circle's variance differs from it by 0.18; of the sum of 64 narrow ones there is left
    // that their middles come in clusters across any one axis: 0.11 (it falls with their number).
    EXPECT_LT(difference(one, disc), 0.2);
    EXPECT_LT(difference(many, disc), 0.13);
}

TEST(BeamsDisc, WithoutADiscTheLineIsSharp) {
    const scene::FrameScene scene = cylinder_lens(0);
    const SheetSet<double> sheets(scene, Event::transmission, 4, 64);
    ASSERT_EQ(sheets.sheets().size(), 1u);
    const auto strip = test::receiver<double>({0, -kDepth, 0}, {0, 1, 0}, {1e-9, 0.1});
    EXPECT_NEAR(sheets.irradiance(strip).x * 1e-9 / (sheets.power().x / 2), 1, 1e-9);
}

TEST(BeamsDisc, KeepsFlatWatersIrradiance) {
    // Widened footprints differ from their own only where E does.
    scene::FrameScene scene = test::scene_of_flat_water({4, 4}, 41, 43);
    scene.state.lights = {test::sun_from_zenith(50)};
    scene.state.lights[0].angular_diameter = kDiameter;
    const SheetSet<double> sheets(scene, Event::transmission, 10);
    const double expected = 3 * test::flat_floor(50, kDepth, kIndex).irradiance;
    const double shift = kDepth * std::tan(std::asin(std::sin(glm::radians(50.0)) / kIndex));
    for (const glm::dvec3 normal : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(-0.3, 1, 0.4))}) {
        const double t = std::asin(std::sin(glm::radians(50.0)) / kIndex);
        const double cosine = -glm::dot(normal, glm::dvec3(std::sin(t), -std::cos(t), 0)) / std::cos(t);
        for (const double size : {0.001, 0.05, 0.4}) {
            const auto pixel = test::receiver<double>({shift, -kDepth, 0}, normal, {size, 0.8 * size});
            EXPECT_NEAR(sheets.irradiance(pixel).x / (expected * cosine), 1, 1e-12);
        }
    }
}

TEST(BeamsDisc, LosesNoLightOfASea) {
    scene::FrameScene scene = test::water_scene({2, 2});
    scene.state.water->absorption = {0, 0, 0};
    test::add_water(scene, test::gentle_sea(), 160, 160);
    scene.state.lights = {test::sun_from_zenith(30)};
    const double middle = kDepth * std::tan(std::asin(std::sin(glm::radians(30.0)) / kIndex));
    const auto lost = [&](double diameter, int sun_samples, double pixel) {
        scene.state.lights[0].angular_diameter = diameter;
        const SheetSet<double> sheets(scene, Event::transmission, 10, sun_samples);
        const int side = static_cast<int>(std::round(3.2 / pixel));
        std::vector<SheetSet<double>::Receiver> floor;
        for (int z = 0; z < side; ++z)
            for (int x = 0; x < side; ++x)
                floor.push_back(test::receiver<double>(
                    {middle + pixel * (x + 0.5 - 0.5 * side), -kDepth, pixel * (z + 0.5 - 0.5 * side)},
                    {0, 1, 0}, glm::dvec2(pixel)));
        double landed = 0;
        for (const glm::dvec3 value : sheets.irradiance(floor)) landed += value.x * pixel * pixel;
        const double share = landed / sheets.power().x - 1;
        printf("pixels of %.3f m, disc of %.4f rad in %2d parts: flux landed 1 %+.1e\n", pixel, diameter,
               sun_samples, share);
        return share;
    };
    // Without a disc pixels tile the floor. Widened ones overlap by what is no whole number of pixels, so
    // that a point of light counts somewhat more or less by where in its pixel it lies: nothing in the mean
    // over places, and what is left of the mean over the folds of this floor.
    EXPECT_NEAR(lost(0, 1, 0.1), 0, 1e-12);
    EXPECT_NEAR(lost(0, 1, 0.025), 0, 1e-12);
    EXPECT_NEAR(lost(0.0093, 1, 0.1), 0, 3e-5);
    EXPECT_NEAR(lost(0.0093, 1, 0.025), 0, 1e-3);
    EXPECT_NEAR(lost(0.0093, 8, 0.025), 0, 1e-3);
}

}  // namespace
}  // namespace dapple
