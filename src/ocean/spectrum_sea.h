#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "ocean/linear_waves.h"
#include "ocean/spectrum.h"
#include "scene/frame_state.h"

namespace dapple::ocean {

/// A JONSWAP sea as a sum of modes that repeats with its period, evaluated on a tile of one period by FFT
/// (Tessendorf 2001, section 4; Horvath 2015). Values at grid points are exact whatever the size of the grid:
/// modes shorter than two cells are folded onto longer ones, which have the same values there.
class SpectrumSea : public LinearWaves {
public:
    /// `water.surface` is a spectrum. Error(timeline_invalid) for too many modes.
    explicit SpectrumSea(const scene::Water& water);

    /// If any of the waves are wanted, the lattice has whole numbers of cells a period, of the form
    /// 2^a 3^b 5^c (asserted).
    SurfaceGrid grid(const Lattice& lattice, double time, FieldMask fields,
                     WaveLengths lengths) const override;
    /// The direct sum over the modes: slow, for single points and tests.
    SurfaceSample sample(double x, double z, double time) const override;
    /// Where the frequencies have no common period some instant comes as close to it as one likes, so no
    /// bound for all times is lower.
    double amplitude_sum() const override { return amplitude_sum_; }
    double mean_square_slope(WaveLengths lengths) const override;
    bool any(WaveLengths lengths) const override;

    /// Most bytes that making grids of `fields` takes beside them, on tiles of `points`, the modes included.
    static double making_bytes(const scene::Water& water, glm::ivec2 points, FieldMask fields);

private:
    /// Of the modes `wanted` (indices), over one period in `points` cells along x and z, from the extent's
    /// corner on.
    SurfaceGrid tile(glm::ivec2 points, double time, FieldMask fields,
                     const std::vector<std::size_t>& wanted) const;

    glm::dvec2 corner_;   ///< m, least x and z of the extent
    glm::ivec2 periods_;  ///< across the extent
    double loop_;
    std::vector<Mode> modes_;
    std::vector<double> lengths_;  ///< m, of the modes
    double amplitude_sum_ = 0;
};

}  // namespace dapple::ocean
