#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "optics/optics.h"

namespace dapple::optics {
namespace {

constexpr double kPi = std::numbers::pi;
/// Below this sin^2 of half the angle Fournier-Forand is its mean.
constexpr double kLeast = 0x1p-26;

/// Gauss-Legendre with 8 points on each of `panels` equal parts.
double integral(double from, double to, int panels, const std::function<double(double)>& f) {
    constexpr double x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    constexpr double w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double half = 0.5 * (to - from) / panels;
    double sum = 0;
    for (int i = 0; i < panels; ++i) {
        const double middle = from + (2 * i + 1) * half;
        for (int k = 0; k < 4; ++k) sum += w[k] * (f(middle - half * x[k]) + f(middle + half * x[k]));
    }
    return half * sum;
}

/// Over the sphere, of p(cos) times `weight`(cos), by s = sin^2(angle / 2) = e^t from both ends, which
/// follows narrow peaks.
double over_sphere(const std::function<double(double)>& p, const std::function<double(double)>& weight) {
    double sum = 0;
    for (const double sign : {1.0, -1.0}) {
        const auto at = [&](double s) {
            const double cosine = sign * (1 - 2 * s);
            return 4 * kPi * p(cosine) * weight(cosine);
        };
        sum += integral(0, kLeast, 4, at);
        sum += integral(std::log(kLeast), std::log(0.5), 400,
                        [&](double t) { return std::exp(t) * at(std::exp(t)); });
    }
    return sum;
}
double one(double) {
    return 1;
}

TEST(Phase, IsotropicIsOneOverTheSphere) {
    EXPECT_DOUBLE_EQ(f64::isotropic_phase(), 0.25 / kPi);
    EXPECT_FLOAT_EQ(f32::isotropic_phase(), static_cast<float>(0.25 / kPi));
}

TEST(Phase, HenyeyGreensteinHasItsMeanCosine) {
    for (const double g : {-0.99, -0.5, -0.001, 0.0, 0.3, 0.8, 0.95, 0.999}) {
        const auto p = [&](double cosine) { return f64::henyey_greenstein_phase(cosine, g); };
        const double tolerance = 1e-9;  // of the quadrature
        EXPECT_NEAR(over_sphere(p, one), 1, tolerance) << g;
        EXPECT_NEAR(over_sphere(p, [](double cosine) { return cosine; }), g, tolerance) << g;
    }
    for (const double cosine : {-1.0, 0.0, 0.7, 1.0}) {
        EXPECT_DOUBLE_EQ(f64::henyey_greenstein_phase(cosine, 0), f64::isotropic_phase());
        EXPECT_NEAR(f64::henyey_greenstein_phase(cosine, 1e-9), f64::isotropic_phase(), 1e-9);
        EXPECT_DOUBLE_EQ(f64::henyey_greenstein_phase(cosine, -0.6),
                         f64::henyey_greenstein_phase(-cosine, 0.6));
    }
    // Straight on: (1 + g) / (4 pi (1 - g)^2).
    EXPECT_NEAR(f64::henyey_greenstein_phase(1, 0.9) * 4 * kPi, 190, 1e-10);
}

TEST(Phase, TwoLobesShareTheLight) {
    const auto p = [](double cosine) { return f64::two_lobe_phase(cosine, 0.9, -0.4, 0.7); };
    EXPECT_NEAR(over_sphere(p, one), 1, 1e-8);
    EXPECT_NEAR(over_sphere(p, [](double cosine) { return cosine; }), 0.7 * 0.9 - 0.3 * 0.4, 1e-8);
    EXPECT_EQ(f64::two_lobe_phase(0.3, 0.9, -0.4, 1), f64::henyey_greenstein_phase(0.3, 0.9));
    EXPECT_EQ(f64::two_lobe_phase(0.3, 0.9, -0.4, 0), f64::henyey_greenstein_phase(0.3, -0.4));
}

struct Particles {
    double index, slope;
};
const std::vector<Particles> kParticles = {{1.1, 3.5835}, {1.02, 3.3},  {1.05, 3.9}, {1.2, 4.5},
                                           {1.35, 3.05},  {1.001, 4.2}, {1.15, 4.9}, {2, 4}};

TEST(Phase, FournierForandIsOneOverTheSphere) {
    for (const auto [index, slope] : kParticles) {
        const auto p = [&](double cosine) { return f64::fournier_forand_phase(cosine, index, slope); };
        EXPECT_NEAR(over_sphere(p, one), 1, 1e-6) << index << ' ' << slope;
        EXPECT_NEAR(f64::fournier_forand_within(1, index, slope), 1, 1e-12) << index << ' ' << slope;
    }
}

TEST(Phase, FournierForandSharesFollowFromIt) {
    for (const auto [index, slope] : kParticles)
        for (const double s : {1e-4, 0.0029, 0.0075, 0.02, 0.3, 0.5, 0.9}) {
            const double between = integral(std::log(s), 0, 100, [&, i = index, k = slope](double t) {
                return 4 * kPi * std::exp(t) * f64::fournier_forand_phase(1 - 2 * std::exp(t), i, k);
            });
            EXPECT_NEAR(f64::fournier_forand_within(s, index, slope), 1 - between, 1e-9)
                << index << ' ' << slope << ' ' << s;
        }
}

/// Backscattered share by Fournier & Jonasz 1999 (also Mobley, Sundman & Boss 2002, equation 8).
double published_backscatter(double index, double slope) {
    const double nu = (3 - slope) / 2, delta = 2 / (3 * (index - 1) * (index - 1)),
                 power = std::pow(delta, nu);
    return 1 - (1 - power * delta - 0.5 * (1 - power)) / ((1 - delta) * power);
}

TEST(Phase, FournierForandScattersBackWhatIsPublished) {
    for (const auto [index, slope] : kParticles) {
        const double back = integral(-1, 0, 50, [&, i = index, k = slope](double cosine) {
            return 2 * kPi * f64::fournier_forand_phase(cosine, i, k);
        });
        EXPECT_NEAR(back, published_backscatter(index, slope), 1e-9) << index << ' ' << slope;
    }
    // Petzold's mean particles (Mobley, Sundman & Boss 2002): 1.83 % backwards by n = 1.10, slope 3.5835.
    EXPECT_NEAR(published_backscatter(1.10, 3.5835), 0.0183, 5e-5);
}

TEST(Phase, FournierForandIsSmoothWhereItsTermsVanish) {
    // Near delta = 1 the series takes over; on both sides of its ends the two ways must agree.
    for (const auto [index, slope] : kParticles)
        for (const double delta : {0.75, 1.0, 1.25}) {
            const double s = delta / f64::fournier_forand_scale(index);
            if (s >= 1) continue;
            const auto p = [&, i = index, k = slope](double at) {
                return f64::fournier_forand_phase(1 - 2 * at, i, k);
            };
            const double step = 1e-7 * s;
            // Second differences of a smooth function vanish with the square of the step.
            EXPECT_NEAR((p(s - step) + p(s + step)) / (2 * p(s)), 1, 1e-9) << index << ' ' << slope;
        }
}

TEST(Phase, NothingIsInfiniteOrNegative) {
    // A cosine may be beyond 1 by its rounding.
    for (const double cosine : {-1.0000002, -1.0, -0.3, 0.0, 0.999, 0.9999999, 1.0, 1.0000002}) {
        for (const auto [index, slope] : kParticles) {
            for (const double p :
                 {f64::fournier_forand_phase(cosine, index, slope),
                  static_cast<double>(f32::fournier_forand_phase(
                      static_cast<float>(cosine), static_cast<float>(index), static_cast<float>(slope)))})
                EXPECT_TRUE(std::isfinite(p) && p >= 0) << cosine << ' ' << index << ' ' << slope << ' ' << p;
        }
        for (const double g : {-0.999999, 0.0, 0.999999}) {
            EXPECT_TRUE(std::isfinite(f64::henyey_greenstein_phase(cosine, g)));
            EXPECT_TRUE(std::isfinite(
                f32::henyey_greenstein_phase(static_cast<float>(cosine), static_cast<float>(g))));
        }
    }
    // The backward term must never take more than there is, over the whole range of the parameters.
    for (double index = 1.01; index <= 2; index += 0.03)
        for (double slope = 3.02; slope < 5; slope += 0.06)
            for (double cosine = -1; cosine < 1; cosine += 0.01)
                ASSERT_GE(f64::fournier_forand_phase(cosine, index, slope), 0)
                    << index << ' ' << slope << ' ' << cosine;
}

TEST(Phase, FloatsLoseLittle) {
    double worst_lobe = 0, worst_ocean = 0;
    for (int i = 1; i < 2000; ++i) {
        const float cosine = static_cast<float>(std::cos(kPi * i / 2000));
        for (const float g : {-0.7f, 0.1f, 0.9f, 0.99f})
            worst_lobe =
                std::max(worst_lobe, std::abs(static_cast<double>(f32::henyey_greenstein_phase(cosine, g)) /
                                                  f64::henyey_greenstein_phase(cosine, g) -
                                              1));
        for (const auto [index, slope] : kParticles) {
            const float n = static_cast<float>(index), k = static_cast<float>(slope);
            worst_ocean =
                std::max(worst_ocean, std::abs(static_cast<double>(f32::fournier_forand_phase(cosine, n, k)) /
                                                   f64::fournier_forand_phase(cosine, n, k) -
                                               1));
        }
    }
    EXPECT_LT(worst_lobe, 2e-6);   // some roundings of 6e-8, of which d^1.5 makes half as many again
    EXPECT_LT(worst_ocean, 2e-4);  // n - 1 of 1.001 has three digits fewer
    std::printf("float: henyey_greenstein %.2g, fournier_forand %.2g\n", worst_lobe, worst_ocean);
}

}  // namespace
}  // namespace dapple::optics
