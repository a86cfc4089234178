#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/water_surface.h"

namespace dapple::reference {

/// The height field of `waves` at one instant, in double, for many points at a time: the sum of
/// ocean::WaterSurface::sample, with sines that a compiler turns into vector code.
class SineSum {
public:
    SineSum(const scene::Waves& waves, double time);

    /// Height [m] and slopes dh/dx, dh/dz at (x, z) [m, world]; all spans of one size.
    void evaluate(std::span<const double> x, std::span<const double> z, std::span<double> height,
                  std::span<double> slope_x, std::span<double> slope_z) const;
    /// Sums of amplitudes and of amplitude * wave number: bounds of height and slope, at all points.
    double height_bound() const { return height_bound_; }
    double slope_bound() const { return slope_bound_; }

private:
    struct Component {
        double turns_x, turns_z;  ///< 1/m, wave vector over 2 pi
        double turns;             ///< phase at the origin over 2 pi, in [-1/2, 1/2]
        double amplitude;         ///< m
        double slope_x, slope_z;  ///< -amplitude * wave vector
    };
    std::vector<Component> components_;
    double height_bound_ = 0;
    double slope_bound_ = 0;
};

}  // namespace dapple::reference
