#include "methods/sliced_beams/segment_quadrature.h"

#include <cmath>

namespace dapple::methods::sliced_beams {
namespace {

/// By Lagrange's polynomials on the three nodes, from the moments of 1, u, u^2.
void from_moments(double m0, double m1, double m2, double (&weight)[3]) {
    constexpr double x = kNodes[2], squared = 0.6;
    weight[0] = (m2 - x * m1) / (2 * squared);
    weight[1] = m0 - m2 / squared;
    weight[2] = (m2 + x * m1) / (2 * squared);
}

/// A root so far off, in halves of the interval, makes a factor that is as good as a polynomial: it is left
/// to the nodes, which are right to 1e-5 there. With the nearer ones the recurrence of the moments loses four
/// digits at most; with a farther one it would lose them all.
constexpr double kFarRoot = 50;

}  // namespace

bool product_weights(double q0, double q1, double q2, double (&weight)[3]) {
    if (q0 < 0) {
        q0 = -q0;
        q1 = -q1;
        q2 = -q2;
    }
    const double at_start = q0 - q1 + q2, at_end = q0 + q1 + q2;
    if (!(at_start > 0) || !(at_end > 0) || !(q0 > 0)) return false;
    const double discriminant = q1 * q1 - 4 * q0 * q2;
    double m0;
    if (discriminant >= 0) {
        const double q = -0.5 * (q1 + std::copysign(std::sqrt(discriminant), q1));
        const double near = q0 / q, far = q / q2;  // far: infinite where q2 is 0
        if (!(std::abs(near) > 1)) return false;
        if (!(std::abs(far) < kFarRoot)) {
            // q0 (1 + b u) (1 - u / far)
            const double b = -1 / near;
            m0 = 2 * std::atanh(b) / b;
            const double m1 = (2 - m0) / b;
            from_moments(m0 / q0, m1 / q0, -m1 / b / q0, weight);
            for (int j = 0; j < 3; ++j) weight[j] /= 1 - kNodes[j] / far;
            return true;
        }
        // Partial fractions; one logarithm, so that roots near each other lose nothing.
        const double z = 2 * (far - near) / ((1 + near) * (1 - far));
        m0 = near == far ? 2 / (q2 * (near * near - 1)) : std::log1p(z) / (q2 * (near - far));
    } else {
        const double x = -0.5 * q1 / q2, y = 0.5 * std::sqrt(-discriminant) / q2;
        m0 = std::atan2(2 * y, x * x + y * y - 1) / (q2 * y);
    }
    const double m1 = (std::log(at_end / at_start) - q1 * m0) / (2 * q2);
    const double m2 = (2 - q0 * m0 - q1 * m1) / q2;
    from_moments(m0, m1, m2, weight);
    return true;
}

}  // namespace dapple::methods::sliced_beams
