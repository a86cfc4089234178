#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "ocean/grid_size.h"
#include "ocean/surface_grid.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// A sum of sinusoids on a grid. On a grid the phase is a sum of a part of the column and a part of the row,
/// so the angle-sum theorem turns each wave into products of tables: cos and sin are taken once a wave and
/// column (here) and once a wave and row (a frame), and a vertex costs a handful of multiplications that
/// vectorise. There is no recurrence whose error could grow.
class WaveSum {
public:
    /// `water.surface` is a list of waves.
    WaveSum(const scene::Water& water, const GridSize& size);

    SurfaceGrid grid(double time, FieldMask fields) const;
    SurfaceSample sample(double x, double z, double time) const;
    /// Sum of the amplitudes, m: a bound of the heights at all times.
    double amplitude_sum() const;

private:
    struct Component {
        glm::dvec2 k;      ///< rad/m
        double omega;      ///< rad/s
        double amplitude;  ///< m
        double phase;      ///< rad
    };
    GridSize size_;
    glm::dvec2 center_;
    glm::dvec2 extent_;
    std::vector<Component> components_;
    std::vector<double> cosine_;  ///< cos(k.x x) of each component and column, component-major
    std::vector<double> sine_;
};

}  // namespace dapple::ocean
