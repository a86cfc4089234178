#pragma once
#include <vector>

#include "render/pilot_frame.h"

namespace dapple::render {

/// Relative L1 distance of two E of one picture: over pixels that both cover and the channels, the sum of
/// |a - b| over that of b; 0 where b is dark.
double relative_difference(const PixelIrradiance& a, const PixelIrradiance& b);

/// How fast E comes to its limit over resolutions that double.
struct Convergence {
    double error = 0;  ///< of the coarsest of three
    double ratio = 1;  ///< of the error of each to that of the one before
};

/// From the relative differences of a resolution to the doubled one, of that to the redoubled one, and of
/// the first to the last. Errors are taken for errors of one kind at all three, a ratio apart, of which one
/// part points the same way (the blur of a kernel) and one does not (where photons happen to lie): with the
/// correlation c of any two, d01^2 = e^2 (1 + r^2 - 2 c r), d02^2 = e^2 (1 + r^4 - 2 c r^2) and r = d12 / d01
/// give e whatever c is. Held to what the triangle's inequality allows, d02 / (1 + r^2) to d02 / (1 - r^2).
/// Where nothing converges the ratio is 1 and the error infinite.
Convergence convergence(double d01, double d12, double d02);

/// Errors of a setting at resolutions from coarse to fine, by power laws between them and, as between the
/// finest two, beyond them.
class ErrorCurve {
public:
    void add(double resolution, double error);  ///< in any order, each resolution once
    bool empty() const { return points_.empty(); }
    /// Infinite below the coarsest, and where it is infinite at either end.
    double at(double resolution) const;
    /// The least resolution, not below the coarsest, from which on the error is `error` or less; infinite
    /// where it does not come to that.
    double resolution_for(double error) const;

private:
    struct Point {
        double resolution, error;
    };
    /// Exponent of the law between a point and the next, or of the finest two.
    double order(std::size_t i) const;
    std::vector<Point> points_;
};

}  // namespace dapple::render
