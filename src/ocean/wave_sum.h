#pragma once
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "ocean/lattice.h"
#include "ocean/surface_grid.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// Lengths of waves, m: from `least` on, below `end`.
struct WaveLengths {
    double least = 0;
    double end = std::numeric_limits<double>::infinity();
    bool hold(double length) const { return length >= least && length < end; }
};

/// A sum of sinusoids on a lattice. On a lattice the phase is a sum of a part of the column and a part of the
/// row, so the angle-sum theorem turns each wave into products of tables: cos and sin are taken once a wave
/// and column and once a wave and row, and a vertex costs a handful of multiplications that vectorise. There
/// is no recurrence whose error could grow.
class WaveSum {
public:
    explicit WaveSum(const scene::Waves& waves);

    /// The waves whose lengths are wanted, at the vertices of the lattice's box; 0 within its hole.
    SurfaceGrid grid(const Lattice& lattice, double time, FieldMask fields, WaveLengths lengths = {}) const;
    SurfaceSample sample(double x, double z, double time) const;
    /// Sum of the amplitudes, m: a bound of the heights at all times.
    double amplitude_sum() const;
    /// Mean over the plane of the slope's square: the sum of (k a)^2 / 2.
    double mean_square_slope(WaveLengths lengths = {}) const;
    bool any(WaveLengths lengths) const;

private:
    struct Component {
        glm::dvec2 k;      ///< rad/m
        double omega;      ///< rad/s
        double amplitude;  ///< m
        double phase;      ///< rad
        double length;     ///< m
    };
    std::vector<Component> components_;
};

}  // namespace dapple::ocean
