#pragma once
#include <complex>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/water_surface.h"

namespace dapple::ocean {

/// JONSWAP energy density [m^2 s / rad] at omega [rad/s] (Hasselmann et al. 1973; Horvath 2015, equations 28
/// to 30, with the exponent 1/3 that its peak frequency lacks in print) times the depth factor of TMA (Bouws
/// et al. 1985 in the form of Thompson & Vincent 1983). amplitude_scale is left out. 0 where there is no wind
/// or fetch.
double energy_density(const scene::Spectrum& spectrum, double omega);

/// omega_p [rad/s] = 22 (g^2 / (U F))^(1/3).
double peak_frequency(const scene::Spectrum& spectrum);

/// D(theta) of cos^2s(theta / 2) spreading, theta [rad] from the wind's heading; its integral over a turn
/// is 1.
double directional_density(double spreading, double theta);

/// One travelling sinusoid of a periodic sea: height = Re(amplitude * exp(i (k . (x, z) - omega t))).
struct Mode {
    int m = 0;  ///< periods across the extent along x and z
    int n = 0;
    std::int64_t cycles = 0;  ///< whole periods in time in a loop; 0 where the sea does not loop
    glm::dvec2 k{0, 0};       ///< rad/m, 2 pi (m / size.x, n / size.z)
    double omega = 0;         ///< rad/s
    double variance = 0;      ///< m^2, expected over seeds: S(omega) D(theta) (domega/dk) / k * dkx dkz
    std::complex<double> amplitude{0, 0};  ///< m; 2 h0 = (xi_r + i xi_i) sqrt(variance)
};

/// Most modes that a spectrum may have.
constexpr double kModeLimit = 2e6;

/// All modes of a sea that repeats over `size` [m] and whose waves are no shorter than cutoff_length, in the
/// order of n, then m. Random numbers depend on seed and (m, n) alone. With a loop, omega is the nearest
/// multiple of 2 pi / loop, at least one. Error(timeline_invalid) beyond kModeLimit.
std::vector<Mode> spectrum_modes(const scene::Spectrum& spectrum, glm::dvec2 size);

/// omega t [rad] of modes at one time. Without a loop it is the product. With one, time is first rounded to
/// a 2^40th of the loop and the phase reduced in integers, so that times that differ by whole loops have the
/// same bits (and rounding errors of the time itself, frame / fps, vanish).
class TimePhase {
public:
    TimePhase(double time, double loop);
    double operator()(const Mode& mode) const;

private:
    double time_;
    bool loops_;
    std::uint64_t ticks_ = 0;  ///< of the loop's 2^40
};

}  // namespace dapple::ocean
