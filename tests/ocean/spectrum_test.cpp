#include "ocean/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "ocean/dispersion.h"
#include "ocean/water_surface.h"

namespace dapple::ocean {
namespace {

constexpr double kPi = std::numbers::pi;

// The integral of S over all omega, by the trapezoidal rule in ln(omega): S falls to nothing at both ends
// (below half the peak like exp(-20), beyond 200 peaks like omega^-4), where the rule's error is far below
// 1e-6; the tail left out is (1 / 200)^4.
double variance_by_quadrature(const scene::Spectrum& s) {
    const double peak = peak_frequency(s);
    const int steps = 40000;
    const double from = std::log(0.25 * peak);
    const double step = (std::log(200 * peak) - from) / steps;
    double sum = 0;
    for (int i = 0; i <= steps; ++i) {
        const double omega = std::exp(from + i * step);
        sum += energy_density(s, omega) * omega * step;
    }
    return sum;
}

double variance_of(const std::vector<Mode>& modes) {
    double sum = 0;
    for (const Mode& mode : modes) sum += mode.variance;
    return sum;
}

// Wave length at the peak, from the deep-water relation without tension (0.1 % off at these lengths).
double peak_length(const scene::Spectrum& s) {
    const double peak = peak_frequency(s);
    return 2 * kPi * kGravity / (peak * peak);
}

TEST(Jonswap, WithoutEnhancementItsVarianceIsClosed) {
    // gamma = 1: the integral of alpha g^2 w^-5 exp(-5/4 (p/w)^4) is alpha g^2 / (5 p^4).
    scene::Spectrum s;
    s.peak_enhancement = 1;
    s.wind_speed = 10;
    s.fetch = 1e5;
    s.depth = 1e6;
    const double alpha = 0.076 * std::pow(100 / (1e5 * 9.81), 0.22);
    const double peak = 22 * std::cbrt(9.81 * 9.81 / 1e6);
    EXPECT_NEAR(peak_frequency(s), peak, 1e-14);
    const double closed = alpha * 9.81 * 9.81 / (5 * std::pow(peak, 4));
    EXPECT_NEAR(variance_by_quadrature(s) / closed, 1, 1e-6);  // see variance_by_quadrature
}

TEST(Jonswap, PeakIsEnhancedByGamma) {
    scene::Spectrum s;
    const double peak = peak_frequency(s);
    scene::Spectrum plain = s;
    plain.peak_enhancement = 1;
    EXPECT_NEAR(energy_density(s, peak) / energy_density(plain, peak), 3.3, 1e-12);
    // One width off the peak, 0.07 below and 0.09 above, gamma^exp(-1/2).
    const double part = std::pow(3.3, std::exp(-0.5));
    EXPECT_NEAR(energy_density(s, 0.93 * peak) / energy_density(plain, 0.93 * peak), part, 1e-12);
    EXPECT_NEAR(energy_density(s, 1.09 * peak) / energy_density(plain, 1.09 * peak), part, 1e-12);
}

TEST(Jonswap, DepthFactorOfTma) {
    scene::Spectrum deep;
    deep.depth = 1e9;
    scene::Spectrum shallow = deep;
    shallow.depth = kGravity;  // omega_h = omega
    EXPECT_NEAR(energy_density(shallow, 0.9) / energy_density(deep, 0.9), 0.405, 1e-12);
    EXPECT_NEAR(energy_density(shallow, 1.5) / energy_density(deep, 1.5), 0.875, 1e-12);
    EXPECT_EQ(energy_density(shallow, 2.5), energy_density(deep, 2.5));
}

TEST(Jonswap, CalmWithoutWindOrFetch) {
    scene::Spectrum s;
    s.wind_speed = 0;
    EXPECT_EQ(energy_density(s, 1), 0);
    EXPECT_TRUE(spectrum_modes(s, {10, 10}).empty());
}

TEST(Spreading, IntegratesToOne) {
    for (const double s : {0.0, 1.0, 4.0, 10.5, 75.0}) {
        // The trapezoidal rule is exact for a trigonometric polynomial; s = 10.5 is one in |cos|, smooth
        // enough.
        const int steps = 4096;
        double sum = 0;
        for (int i = 0; i < steps; ++i) sum += directional_density(s, 2 * kPi * i / steps) * 2 * kPi / steps;
        EXPECT_NEAR(sum, 1, 1e-12) << s;
    }
    EXPECT_NEAR(directional_density(0, 1.0), 1 / (2 * kPi), 1e-15);
    EXPECT_NEAR(directional_density(1, kPi), 0, 1e-30);  // nothing against the wind
}

// Ten peak lengths and 25 cells a peak length; the cut-off is two cells, the shortest wave that such a grid
// holds. The quadrature goes on to infinity: beyond the cut-off lies about 0.5 % of the variance, which the 1
// % has to bear.
TEST(Spectrum, SumOverModesIsTheIntegralOfTheDensity) {
    struct Case {
        double spreading;
        double depth;
    };
    for (const Case& c : {Case{0, 1e4}, Case{4, 1e4}, Case{16, 1e4}, Case{4, 3}}) {
        scene::Spectrum s;
        s.wind_heading = 0.7;
        s.spreading = c.spreading;
        s.depth = c.depth;
        const double length = peak_length(s);
        s.cutoff_length = 2 * length / 25;
        const double significant_height = 4 * std::sqrt(variance_by_quadrature(s));
        const double sum = variance_of(spectrum_modes(s, {10 * length, 12 * length}));
        EXPECT_NEAR(sum / (significant_height * significant_height / 16), 1, 0.01)
            << c.spreading << " " << c.depth;
    }
}

TEST(Spectrum, VarianceOfTheHeightOverSeeds) {
    scene::Water water;
    water.surface.type = scene::WaterSurfaceType::spectrum;
    scene::Spectrum& s = water.surface.spectrum;
    s.cutoff_length = 2;
    s.depth = 3;
    s.amplitude_scale = 0.5;
    water.extent.size = {40, 30};
    water.mesh_cells =
        60;  // three cells a shortest wave: the mean square over the grid is that over the patch
    const double expected = variance_of(spectrum_modes(s, water.extent.size));
    const int seeds = 32;
    double sum = 0;
    double sum_of_squares = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        s.seed = static_cast<std::uint64_t>(seed);
        const SurfaceGrid grid = WaterSurface(water).grid(3.5, kHeight);
        double square = 0;
        for (int row = 0; row + 1 < grid.rows; ++row) {
            for (int column = 0; column + 1 < grid.columns; ++column) {
                const double h = grid[Field::height][static_cast<std::size_t>(row * grid.columns + column)];
                square += h * h;
            }
        }
        square /= (grid.rows - 1) * (grid.columns - 1);
        sum += square;
        sum_of_squares += square * square;
    }
    const double mean = sum / seeds;
    const double standard_error = std::sqrt((sum_of_squares / seeds - mean * mean) / (seeds - 1));
    EXPECT_NEAR(mean, expected, 3 * standard_error);
    EXPECT_LT(standard_error, 0.1 * expected);  // so that the line above says something
}

TEST(Spectrum, ModesStopAtTheCutOff) {
    scene::Spectrum s;
    s.cutoff_length = 0.5;
    double shortest = 1e9;
    for (const Mode& mode : spectrum_modes(s, {10, 5})) {
        shortest = std::min(shortest, 2 * kPi / glm::length(mode.k));
    }
    EXPECT_NEAR(shortest, 0.5, 1e-12);  // 20 waves along x, 10 along z: the cut-off itself is a mode
}

TEST(Spectrum, TooManyModesAreRefused) {
    scene::Spectrum s;
    s.cutoff_length = 0.01;
    try {
        spectrum_modes(s, {1000, 1000});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::timeline_invalid);
        EXPECT_NE(std::string(error.what()).find("cutoff_length"), std::string::npos);
    }
}

TEST(Spectrum, LoopTakesTheNearestWholeNumberOfCycles) {
    scene::Spectrum s;
    s.loop = 1.5;
    s.cutoff_length = 1;
    const double base = 2 * kPi / s.loop;
    bool some_first = false;
    for (const Mode& mode : spectrum_modes(s, {60, 60})) {
        const double natural = angular_frequency(glm::length(mode.k), s.depth);
        EXPECT_DOUBLE_EQ(mode.omega, base * static_cast<double>(mode.cycles));
        ASSERT_GE(mode.cycles, 1);
        const bool raised = natural < 0.5 * base;  // to one cycle
        EXPECT_TRUE(raised || std::abs(mode.omega - natural) <= 0.5 * base * (1 + 1e-12));
        some_first = some_first || raised;
    }
    EXPECT_TRUE(some_first) << "no wave is slower than half a cycle a loop: the least of one is not tested";
}

}  // namespace
}  // namespace dapple::ocean
