#include "ocean/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "ocean/dispersion.h"

namespace dapple::ocean {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kTickBits = 40;
constexpr std::uint64_t kTickMask = (std::uint64_t{1} << kTickBits) - 1;

// Kitaigorodskii's depth factor as fitted by Thompson & Vincent.
double depth_factor(double omega, double depth) {
    const double h = omega * std::sqrt(depth / kGravity);
    if (h <= 1) return 0.5 * h * h;
    if (h <= 2) return 1 - 0.5 * (2 - h) * (2 - h);
    return 1;
}

// Two independent normal numbers (Box & Muller 1958) of a mode.
std::complex<double> gaussian_pair(std::uint64_t seed, int m, int n) {
    const std::uint64_t index =
        (std::uint64_t{static_cast<std::uint32_t>(m)} << 32) | static_cast<std::uint32_t>(n);
    // Half a step of the 32-bit grid keeps the logarithm away from 0.
    const double radius = std::sqrt(-2 * std::log(hash_uniform(seed, 0, index, 0) + 0x1p-33));
    const double angle = 2 * kPi * hash_uniform(seed, 0, index, 1);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

double peak_frequency(const scene::Spectrum& spectrum) {
    return 22 * std::cbrt(kGravity * kGravity / (spectrum.wind_speed * spectrum.fetch));
}

double energy_density(const scene::Spectrum& spectrum, double omega) {
    const double wind = spectrum.wind_speed;
    if (wind <= 0 || spectrum.fetch <= 0 || omega <= 0) return 0;
    const double alpha = 0.076 * std::pow(wind * wind / (spectrum.fetch * kGravity), 0.22);
    const double peak = peak_frequency(spectrum);
    const double width = omega <= peak ? 0.07 : 0.09;
    const double offset = (omega - peak) / (width * peak);
    const double enhancement = std::pow(spectrum.peak_enhancement, std::exp(-0.5 * offset * offset));
    const double ratio = peak / omega;
    return alpha * kGravity * kGravity * std::pow(omega, -5) *
           std::exp(-1.25 * ratio * ratio * ratio * ratio) * enhancement *
           depth_factor(omega, spectrum.depth);
}

double directional_density(double spreading, double theta) {
    // The integral of cos^2s(theta / 2) over a turn is 2 sqrt(pi) Gamma(s + 1/2) / Gamma(s + 1).
    const double normalisation =
        std::exp(std::lgamma(spreading + 1) - std::lgamma(spreading + 0.5)) / (2 * std::sqrt(kPi));
    return normalisation * std::pow(std::abs(std::cos(0.5 * theta)), 2 * spreading);
}

std::vector<Mode> spectrum_modes(const scene::Spectrum& spectrum, glm::dvec2 size) {
    const double longest_x = size.x / spectrum.cutoff_length;
    const double longest_z = size.y / spectrum.cutoff_length;
    if (!(kPi * longest_x * longest_z <= kModeLimit)) {
        throw Error(ExitCode::timeline_invalid,
                    "water.surface.cutoff_length: waves down to " + std::to_string(spectrum.cutoff_length) +
                        " m are more than 2 million in the sea's period, " + std::to_string(size.x) +
                        " m by " + std::to_string(size.y) +
                        " m; use a longer cut-off, a smaller extent or a shorter period");
    }
    const int rows = static_cast<int>(longest_z);
    const double shortest_k = 2 * kPi / spectrum.cutoff_length;
    const double cell = (2 * kPi / size.x) * (2 * kPi / size.y);  // dkx dkz

    std::vector<std::vector<Mode>> of_row(2 * static_cast<std::size_t>(rows) + 1);
    parallel_for(of_row.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const int n = static_cast<int>(row) - rows;
            const int columns = static_cast<int>(longest_x);
            for (int m = -columns; m <= columns; ++m) {
                Mode mode;
                mode.m = m;
                mode.n = n;
                mode.k = 2 * kPi * glm::dvec2(m / size.x, n / size.y);
                const double k = std::hypot(mode.k.x, mode.k.y);
                if (k == 0 || k > shortest_k * (1 + 1e-12)) continue;  // the shortest wave itself is in
                const double omega = angular_frequency(k, spectrum.depth);
                const double theta = std::atan2(mode.k.y, mode.k.x) - spectrum.wind_heading;
                mode.variance = spectrum.amplitude_scale * spectrum.amplitude_scale *
                                energy_density(spectrum, omega) *
                                directional_density(spectrum.spreading, theta) *
                                group_velocity(k, spectrum.depth) / k * cell;
                if (!(mode.variance > 0)) continue;
                mode.amplitude = std::copysign(std::sqrt(mode.variance), spectrum.amplitude_scale) *
                                 gaussian_pair(spectrum.seed, m, n);
                mode.omega = omega;
                if (spectrum.loop > 0) {
                    const double base = 2 * kPi / spectrum.loop;
                    mode.cycles = std::max<std::int64_t>(1, std::llround(omega / base));
                    mode.omega = base * static_cast<double>(mode.cycles);
                }
                of_row[row].push_back(mode);
            }
        }
    });
    std::vector<Mode> modes;
    for (const auto& row : of_row) modes.insert(modes.end(), row.begin(), row.end());
    return modes;
}

TimePhase::TimePhase(double time, double loop) : time_(time), loops_(loop > 0) {
    if (!loops_) return;
    const double turns = time / loop;
    const double part = std::ldexp(turns - std::floor(turns), kTickBits);
    ticks_ = static_cast<std::uint64_t>(std::llround(part)) & kTickMask;
}

double TimePhase::operator()(const Mode& mode) const {
    if (!loops_) return mode.omega * time_;
    // Wraps modulo 2^64, of which 2^40 is a divisor: exact.
    const std::uint64_t part = (static_cast<std::uint64_t>(mode.cycles) * ticks_) & kTickMask;
    return 2 * kPi * std::ldexp(static_cast<double>(part), -kTickBits);
}

}  // namespace dapple::ocean
