#pragma once
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/caustic_method.h"
#include "methods/sliced_beams/layer_tiles.h"
#include "methods/sliced_beams/light_lattice.h"
#include "methods/sliced_beams/sheet_coverage.h"

namespace dapple::methods::sliced_beams {

/// The same coverage as SheetCoverage::add, on the device: the CPU finds each tile's clusters of beams, the
/// device lands and clips them, four receivers an invocation, each adding up its own list in its fixed order.
/// What a device is bad at stays on the CPU, tile by tile: shadow rays, beams cut by the surface, nodes added
/// whole, and tiles with very many beams. Arithmetic is that of the CPU, operation by operation, so that
/// results differ by the order of sums only; the same bits from run to run on one device.
class CoveragePass {
public:
    using Sheets = std::span<const std::unique_ptr<SheetCoverage<float>>>;

    explicit CoveragePass(gpu::Device& device);
    ~CoveragePass();

    /// Takes the sheets of a frame, which must outlive their use here. False, and nothing is taken, where
    /// their mesh is larger than what the device binds.
    bool begin(Sheets sheets);
    /// E of all receivers of a layer, W/m^2; by `lattice`, which may be null, of those that it shares. Throws
    /// Error(device).
    void irradiance(const LayerTiles& tiles, const LightLattice* lattice, LayerResult& result,
                    QueryCounts& counts, FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::sliced_beams
