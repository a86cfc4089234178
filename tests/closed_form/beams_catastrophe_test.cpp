// Folds, cusps and a perfect focus, by sliced beams in double.
#include <gtest/gtest.h>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"

namespace dapple {
namespace {

using light::Event;
using test::SheetSet;

constexpr double kIndex = 1.333;
constexpr double kReduced = (kIndex - 1) / kIndex;  // slope of a ray over that of the water, paraxial

/// One wave of 1 m, h = a cos(kx), in a strip of 2^16 cells along x and one across, under an overhead sun.
/// Slopes of 1e-4: the paraxial laws hold to their square.
class Strip {
public:
    static constexpr int kCells = 1 << 16;
    static constexpr double kWave = 2 * glm::pi<double>();  // rad/m
    static constexpr double kAmplitude = 1e-4 / kWave;
    /// First focus below the crest, m.
    static constexpr double kFocus = 1 / (kReduced * kAmplitude * kWave * kWave);

    Strip() : scene_(make()), sheets_(scene_, Event::transmission, 3 * kFocus) {}

    /// E over that of flat water at x on a level floor at `kappa` times the focus; mean over `width` m in x.
    double irradiance(double x, double kappa, double width) const {
        const auto pixel = test::receiver<double>({x, -kappa * kFocus, 0}, {0, 1, 0}, {width, 0.5});
        return sheets_.irradiance(pixel).x / test::flat_floor(0, 1, kIndex).irradiance;
    }

private:
    static scene::FrameScene make() {
        scene::FrameScene scene = test::scene_of_water({1, 1}, kCells, 1, [](double x, double) {
            return kAmplitude * glm::dvec3(std::cos(kWave * x), -kWave * std::sin(kWave * x), 0);
        });
        scene.state.lights = {test::sun_from_zenith(0)};
        scene.state.lights[0].irradiance = {1, 1, 1};
        return scene;
    }

    scene::FrameScene scene_;
    SheetSet<double> sheets_;
};

/// E(distance) = constant * (k distance)^exponent, by least squares of the logarithms over distances evenly
/// spaced in these.
struct PowerLaw {
    double exponent = 0, constant = 0;
};

template <class Irradiance>
PowerLaw fit(double nearest, double farthest, double fixed_exponent, Irradiance&& irradiance) {
    constexpr int points = 60;
    double sx = 0, sy = 0, sxx = 0, sxy = 0, level = 0;
    for (int i = 0; i < points; ++i) {
        const double distance = nearest * std::pow(farthest / nearest, i / (points - 1.0));
        // A pixel of a twentieth of its distance: its mean is within 1e-4 of the value at its middle.
        const double value = irradiance(distance, distance / 20);
        const double x = std::log(Strip::kWave * distance), y = std::log(value);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        level += y - fixed_exponent * x;
    }
    return {(points * sxy - sx * sy) / (points * sxx - sx * sx), std::exp(level / points)};
}

TEST(BeamsCatastrophe, BeforeTheFocusTheStripHasItsExactIrradiance) {
    const Strip strip;
    double worst = 0;
    for (const double phase : {-2.0, -0.3, 0.0, 1.0, 2.5}) {  // on the water, rad
        const double lands = phase - 0.5 * std::sin(phase);
        const double value = strip.irradiance(lands / Strip::kWave, 0.5, 1e-4);
        worst = std::max(worst, std::abs(value * (1 - 0.5 * std::cos(phase)) - 1));
    }
    printf("before the focus: off by %.1e\n", worst);
    // Beams are a tenth of the pixel wide and E changes by 5e-5 of itself from one to the next: the two that
    // the pixel's edges cut are off by half of that.
    EXPECT_LT(worst, 2e-6);
}

TEST(BeamsCatastrophe, AFoldHasExponentMinusOneHalf) {
    const Strip strip;
    for (const double kappa : {1.5, 2.0}) {
        // The edge of the light of the phases about arccos(1 / kappa); bright towards 0 where that phase
        // lands on the negative side.
        const double edge = (std::sqrt(kappa * kappa - 1) - std::acos(1 / kappa)) / Strip::kWave;
        // From 40 cells about the fold on the water (X'' / 2 of them are 2e-6 m) to where the third path and
        // the next terms, of the order of (k distance)^(1/2), are below a hundredth.
        const PowerLaw law = fit(2e-6, 5e-5, -0.5, [&](double distance, double width) {
            return strip.irradiance(edge - distance, kappa, width);
        });
        const double constant = std::sqrt(2 / std::sqrt(kappa * kappa - 1));
        printf("fold at %.1f focus lengths: exponent %.4f, constant %.4f of the law's\n", kappa, law.exponent,
               law.constant / constant);
        EXPECT_NEAR(law.exponent, -0.5, 0.005);
        EXPECT_NEAR(law.constant / constant, 1, 0.01);  // the third path's light is 0.2 to 0.8 %
        // Beyond the edge nothing but the third path.
        EXPECT_LT(strip.irradiance(edge + 1e-6, kappa, 1e-6), 1);
    }
}

TEST(BeamsCatastrophe, ACuspHasExponentMinusTwoThirdsAndItsConstant) {
    const Strip strip;
    for (const double side : {-1.0, 1.0}) {
        // k X = u^3 / 6 with u = k x on the water: from 80 cells to u = 0.13, where the next term, u^2 / 20,
        // is a thousandth.
        const PowerLaw law = fit(1.2e-8, 6e-5, -2.0 / 3, [&](double distance, double width) {
            return strip.irradiance(side * distance, 1, width);
        });
        printf("cusp: exponent %.4f, constant %.4f\n", law.exponent, law.constant);
        EXPECT_NEAR(law.exponent, -2.0 / 3, 0.01);
        EXPECT_NEAR(law.constant, 2 / std::pow(6, 2.0 / 3), 0.01 * 0.6057);
    }
}

/// A bump of a prolate ellipsoid of eccentricity 1 / n, axis upright: it sends light along its axis to its
/// lower focus, free of aberration (Descartes).
class Lens {
public:
    static constexpr double kFocusDepth = 2, kSide = 0.6;

    explicit Lens(double paraboloid = 0) : scene_(make(paraboloid)) {}
    const scene::FrameScene& scene() const { return scene_; }
    scene::FrameScene& scene() { return scene_; }

private:
    static scene::FrameScene make(double paraboloid) {
        const double major = kFocusDepth / (1 + 1 / kIndex);
        const double squeeze = 1 - 1 / (kIndex * kIndex);  // (minor / major)^2
        scene::FrameScene scene = test::scene_of_water({kSide, kSide}, 64, 64, [&](double x, double z) {
            const double r2 = x * x + z * z;
            const double y = std::sqrt(major * major - r2 / squeeze);  // above the ellipsoid's centre
            const glm::dvec3 cap(y - major, -x / (squeeze * y), -z / (squeeze * y));
            const double curve = 1 / (major * squeeze);
            const glm::dvec3 parabola(-0.5 * curve * r2, -curve * x, -curve * z);
            return glm::mix(cap, parabola, paraboloid);
        });
        scene.state.lights = {test::sun_from_zenith(0)};
        scene.state.lights[0].irradiance = {1, 1, 1};
        return scene;
    }

    scene::FrameScene scene_;
};

template <class Real>
double mean_miss(const light::BeamSheet<Real>& sheet) {
    double sum = 0;
    for (const auto& ray : sheet.rays) {
        const double depth = Lens::kFocusDepth;
        sum += std::hypot(static_cast<double>(ray.a) + depth * static_cast<double>(ray.slope_a),
                          static_cast<double>(ray.b) + depth * static_cast<double>(ray.slope_b));
    }
    return sum / static_cast<double>(sheet.rays.size());
}

template <class Real>
void expect_perfect_focus(double pixel, double miss) {
    const Lens lens;
    const SheetSet<Real> sheets(lens.scene(), Event::transmission, 3);
    ASSERT_EQ(sheets.sheets().size(), 1u);
    const auto& sheet = sheets.sheets()[0]->sheet();
    printf("mean miss of the focus: %.1e m\n", mean_miss(sheet));
    EXPECT_LT(mean_miss(sheet), miss);
    // Of light through 0.36 m^2 at up to 30 degrees, T is at least 0.978.
    const double power = sheets.power().x;
    EXPECT_GT(power, 0.978 * 0.36);
    EXPECT_LT(power, 0.98 * 0.36);
    for (const glm::dvec3 normal : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(0.5, 1, 0.2))}) {
        const glm::dvec3 focus(0, -Lens::kFocusDepth, 0);
        const auto at_focus = test::receiver<Real>(focus, normal, glm::dvec2(pixel));
        const double caught = sheets.irradiance(at_focus).x * pixel * pixel;
        // The sum of 8 192 fluxes in another order.
        EXPECT_NEAR(caught / power, 1, 64 * static_cast<double>(std::numeric_limits<Real>::epsilon()));
        const auto beside = test::receiver<Real>(focus + glm::dvec3(at_focus.u), normal, glm::dvec2(pixel));
        EXPECT_EQ(sheets.irradiance(beside).x, 0);
    }
}

TEST(BeamsCatastrophe, AllLightOfAPerfectLensIsInThePixelOfItsFocus) {
    expect_perfect_focus<double>(1e-12, 1e-15);
    expect_perfect_focus<float>(1e-5, 2e-7);
}

TEST(BeamsCatastrophe, AParaboloidMissesTheFocusByItsAberration) {
    // The counter-check: the same curvature at the top, no ellipsoid.
    const Lens lens(1);
    const SheetSet<double> sheets(lens.scene(), Event::transmission, 3);
    EXPECT_GT(mean_miss(sheets.sheets()[0]->sheet()), 1e-3);
    const auto at_focus = test::receiver<double>({0, -Lens::kFocusDepth, 0}, {0, 1, 0}, glm::dvec2(1e-3));
    EXPECT_LT(sheets.irradiance(at_focus).x * 1e-6, 0.5 * sheets.power().x);
}

}  // namespace
}  // namespace dapple
