#include "ocean/dispersion.h"

#include <cmath>

namespace dapple::ocean {

double angular_frequency(double wave_number, double depth) {
    const double k = wave_number;
    return std::sqrt((kGravity * k + kKinematicSurfaceTension * k * k * k) * std::tanh(k * depth));
}

double group_velocity(double wave_number, double depth) {
    const double k = wave_number;
    const double restoring = kGravity * k + kKinematicSurfaceTension * k * k * k;
    const double restoring_slope = kGravity + 3 * kKinematicSurfaceTension * k * k;
    const double t = std::tanh(k * depth);
    return (restoring_slope * t + restoring * depth * (1 - t * t)) / (2 * std::sqrt(restoring * t));
}

}  // namespace dapple::ocean
