#pragma once

namespace dapple::ocean {

constexpr double kGravity = 9.81;                    ///< m/s^2
constexpr double kKinematicSurfaceTension = 7.4e-5;  ///< m^3/s^2, sigma / rho of clean water

/// omega [rad/s] of linear waves of wave number k [rad/m] over water of `depth` [m]:
/// omega^2 = (g k + (sigma / rho) k^3) tanh(k depth) (Lamb, Hydrodynamics, sections 228 and 266).
double angular_frequency(double wave_number, double depth);

/// d(omega)/dk [m/s], the group velocity of the same relation; k > 0.
double group_velocity(double wave_number, double depth);

}  // namespace dapple::ocean
