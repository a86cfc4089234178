#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "ocean/linear_waves.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// A sum of sinusoids on a lattice. On a lattice the phase is a sum of a part of the column and a part of the
/// row, so the angle-sum theorem turns each wave into products of tables: cos and sin are taken once a wave
/// and column and once a wave and row, and a vertex costs a handful of multiplications that vectorise. There
/// is no recurrence whose error could grow.
class WaveSum : public LinearWaves {
public:
    explicit WaveSum(const scene::Waves& waves);

    SurfaceGrid grid(const Lattice& lattice, double time, FieldMask fields,
                     WaveLengths lengths) const override;
    SurfaceSample sample(double x, double z, double time) const override;
    double amplitude_sum() const override;
    double mean_square_slope(WaveLengths lengths) const override;
    bool any(WaveLengths lengths) const override;

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
