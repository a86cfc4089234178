#pragma once
#include <cstddef>
#include <memory>
#include <span>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/sliced_beams/scatter_layer.h"
#include "methods/sliced_beams/scatter_sheet.h"

namespace dapple::methods::sliced_beams {

/// The light that even water scatters out of beams, on the device: each invocation walks one segment through
/// a sheet's pyramid, finds its pieces in beams and adds up their light in a fixed order. The formulas are
/// those of ScatterSheet::add but for rules of quadrature, where the CPU has cheaper ones (moments of a
/// cluster, two nodes), and for cuts and peaks of the light, which the CPU finds in double: both are off by
/// some 1e-6. The same bits from run to run on one device, whatever segments go together. A dispatch
/// walks so many nodes of so many segments at most, to be short of what watchdogs allow, and there are as
/// many as it takes; but pieces that were met are finished in it, and those of thick or very uneven water
/// may have hundreds of parts. Beams among whose rays an object may stand, and water with bounded media in
/// it, stay on the CPU.
class ScatterPass {
public:
    explicit ScatterPass(gpu::Device& device);
    ~ScatterPass();

    /// Forgets all sheets.
    void clear();
    /// Takes the light of all of a sheet's beams but those that ScatterSheet::keep_mixed() keeps; the sheet
    /// need not outlive this. False, and nothing is taken, where it has none or more than what the device
    /// binds.
    bool take(const ScatterSheet<float>& sheet, std::size_t index);
    bool takes(std::size_t index) const;

    /// Of one of the sheets that it takes, by the index it was given.
    struct Direction {
        std::size_t sheet;
        LightDirection<float> light;
        float share;  ///< of the sheet's light
    };
    /// Adds what reaches the near ends of a layer's segments in the water, W/m^2/sr; adds costs to the pass
    /// "scattering". Throws Error(device).
    void add(const LayerSegments& segments, std::span<const Direction> directions,
             const EvenMedium<float>& medium, std::span<glm::vec3> radiance, ScatterCounts& counts,
             FrameStats& stats);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::sliced_beams
