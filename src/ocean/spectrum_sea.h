#pragma once
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "ocean/grid_size.h"
#include "ocean/spectrum.h"
#include "ocean/surface_grid.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// A JONSWAP sea as a sum of modes that repeats with its extent, evaluated on a grid by FFT (Tessendorf 2001,
/// section 4; Horvath 2015). Values at grid points are exact whatever the size of the grid: modes shorter
/// than two cells are folded onto longer ones, which have the same values there.
class SpectrumSea {
public:
    /// `water.surface` is a spectrum. Error(timeline_invalid) for too many modes.
    SpectrumSea(const scene::Water& water, const GridSize& size);

    SurfaceGrid grid(double time, FieldMask fields) const;
    /// The direct sum over the modes: slow, for single points and tests.
    SurfaceSample sample(double x, double z, double time) const;
    /// Sum of the amplitudes, m: a bound of heights and (at choppiness 1) of displacements. Where the
    /// frequencies have no common period some instant comes as close to it as one likes, so no bound for all
    /// times is lower.
    double amplitude_sum() const { return amplitude_sum_; }

private:
    glm::dvec2 corner_;  ///< m, x and z of the grid's first vertex
    GridSize size_;
    double loop_;
    std::vector<Mode> modes_;
    std::vector<int> used_rows_;
    std::vector<std::size_t> row_slot_;  ///< of each row of the grid: its place among the used ones
    double amplitude_sum_ = 0;
};

}  // namespace dapple::ocean
