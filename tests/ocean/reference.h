#pragma once
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "ocean/surface_grid.h"

namespace dapple::ocean {

/// One sinusoid, height = amplitude cos(k . (x, z) - omega t + phase), in long double: what the fast sums are
/// held against. The derivatives are written out here once more, field by field.
struct ReferenceWave {
    double kx, kz, omega, amplitude, phase;

    std::array<long double, kFieldCount> fields(long double x, long double z, long double t) const {
        const long double p = kx * x + kz * z - omega * t + phase;
        const long double c = amplitude * std::cos(p);
        const long double s = amplitude * std::sin(p);
        const long double k = std::hypot(static_cast<long double>(kx), static_cast<long double>(kz));
        // Gerstner: a particle moves against the wave's direction by a sin(phase), which gathers particles on
        // crests.
        return {c,
                -kx * s,
                -kz * s,
                omega * s,
                kx * omega * c,
                kz * omega * c,
                -kx * kx * c,
                -kx * kz * c,
                -kz * kz * c,
                -kx / k * s,
                -kz / k * s,
                -kx * kx / k * c,
                -kx * kz / k * c,
                -kz * kz / k * c};
    }

    /// Largest value of each field.
    std::array<double, kFieldCount> amplitudes() const {
        const double a = std::abs(amplitude);
        const double k = std::hypot(kx, kz);
        const double w = std::abs(omega);
        return {a,         a * k,     a * k, a * w, a * k * w, a * k * w, a * k * k,
                a * k * k, a * k * k, a,     a,     a * k,     a * k,     a * k};
    }
};

constexpr FieldMask kAllFields = (FieldMask{1} << kFieldCount) - 1;

}  // namespace dapple::ocean
