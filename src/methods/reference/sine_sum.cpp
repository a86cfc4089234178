#include "methods/reference/sine_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "ocean/dispersion.h"

namespace dapple::reference {
namespace {

/// Adding and taking away 1.5 * 2^52 rounds a double below 2^51 to the nearest whole number.
constexpr double kRounder = 0x1.8p52;

double whole(double value) {
    return (value + kRounder) - kRounder;
}

struct SineCosine {
    double sine, cosine;
};

/// Of 2 pi * turns: a quarter of the angle, at most pi / 4, by Taylor's series (rest below 5e-17), doubled
/// twice. No branches, so that loops over it vectorise. Errors are absolute, about 1e-15.
inline SineCosine sine_cosine(double turns) {
    const double a = 0.5 * std::numbers::pi * (turns - whole(turns));
    const double q = a * a;
    double s = -1.0 / 1307674368000.0;
    s = std::fma(s, q, 1.0 / 6227020800.0);
    s = std::fma(s, q, -1.0 / 39916800.0);
    s = std::fma(s, q, 1.0 / 362880.0);
    s = std::fma(s, q, -1.0 / 5040.0);
    s = std::fma(s, q, 1.0 / 120.0);
    s = std::fma(s, q, -1.0 / 6.0);
    s = a + a * q * s;
    double c = 1.0 / 20922789888000.0;
    c = std::fma(c, q, -1.0 / 87178291200.0);
    c = std::fma(c, q, 1.0 / 479001600.0);
    c = std::fma(c, q, -1.0 / 3628800.0);
    c = std::fma(c, q, 1.0 / 40320.0);
    c = std::fma(c, q, -1.0 / 720.0);
    c = std::fma(c, q, 1.0 / 24.0);
    c = std::fma(c, q, -0.5);
    c = 1 + q * c;
    const double s2 = 2 * s * c;
    const double c2 = 1 - 2 * s * s;
    return {2 * s2 * c2, 1 - 2 * s2 * s2};
}

constexpr std::size_t kBlock = 256;

}  // namespace

SineSum::SineSum(const scene::Waves& waves, double time) {
    for (const scene::Wave& wave : waves.waves) {
        if (wave.amplitude == 0) continue;
        const double k = 2 * std::numbers::pi / wave.length;
        const glm::dvec2 vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        const double phase = wave.phase - ocean::angular_frequency(k, waves.depth) * time;
        constexpr double per_turn = 0.5 / std::numbers::pi;
        components_.push_back({per_turn * vector.x, per_turn * vector.y,
                               std::remainder(per_turn * phase, 1.0), wave.amplitude,
                               -wave.amplitude * vector.x, -wave.amplitude * vector.y});
        height_bound_ += std::abs(wave.amplitude);
        slope_bound_ += std::abs(wave.amplitude) * k;
    }
}

void SineSum::evaluate(std::span<const double> x, std::span<const double> z, std::span<double> height,
                       std::span<double> slope_x, std::span<double> slope_z) const {
    // Local arrays, so that the compiler knows that nothing overlaps.
    std::array<double, kBlock> px{}, pz{};
    for (std::size_t first = 0; first < x.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, x.size() - first);
        std::array<double, kBlock> h{}, sx{}, sz{};
        std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(first), count, px.begin());
        std::copy_n(z.begin() + static_cast<std::ptrdiff_t>(first), count, pz.begin());
        for (const Component& wave : components_) {
            for (std::size_t i = 0; i < count; ++i) {
                const auto [sine, cosine] =
                    sine_cosine(wave.turns_x * px[i] + wave.turns_z * pz[i] + wave.turns);
                h[i] += wave.amplitude * cosine;
                sx[i] += wave.slope_x * sine;
                sz[i] += wave.slope_z * sine;
            }
        }
        std::copy_n(h.begin(), count, height.begin() + static_cast<std::ptrdiff_t>(first));
        std::copy_n(sx.begin(), count, slope_x.begin() + static_cast<std::ptrdiff_t>(first));
        std::copy_n(sz.begin(), count, slope_z.begin() + static_cast<std::ptrdiff_t>(first));
    }
}

}  // namespace dapple::reference
