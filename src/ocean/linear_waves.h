#pragma once
#include <glm/glm.hpp>
#include <limits>

#include "ocean/lattice.h"
#include "ocean/surface_grid.h"

namespace dapple::ocean {

/// Lengths of waves, m: from `least` on, below `end`.
struct WaveLengths {
    double least = 0;
    double end = std::numeric_limits<double>::infinity();
    bool hold(double length) const { return length >= least && length < end; }
};

/// A sum of travelling sinusoids. All functions are thread-safe and run on parallel_for; the bits of their
/// results do not depend on the number of threads.
class LinearWaves {
public:
    LinearWaves() = default;
    LinearWaves(const LinearWaves&) = delete;
    LinearWaves& operator=(const LinearWaves&) = delete;
    virtual ~LinearWaves() = default;

    /// The waves whose lengths are wanted, at the vertices of the lattice's box, before any horizontal
    /// displacement; 0 within its hole.
    virtual SurfaceGrid grid(const Lattice& lattice, double time, FieldMask fields,
                             WaveLengths lengths) const = 0;
    /// All waves at one point; m, s.
    virtual SurfaceSample sample(double x, double z, double time) const = 0;
    /// Sum of the amplitudes, m: a bound at all times of heights and (at choppiness 1) of displacements.
    virtual double amplitude_sum() const = 0;
    /// Mean over the plane of the slope's square: the sum of (k a)^2 / 2.
    virtual double mean_square_slope(WaveLengths lengths) const = 0;
    virtual bool any(WaveLengths lengths) const = 0;
};

}  // namespace dapple::ocean
