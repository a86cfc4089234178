#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/sliced_beams/scatter_sheet.h"
#include "view/segment_layer.h"

namespace dapple::methods::sliced_beams {

/// Segments of neighboring pixels that follow each other in no path and lie on one side of the water: what is
/// worked on at a time.
struct LayerGroup {
    bool in_water = false;
    SegmentGroup<float> segments;
    std::array<std::uint32_t, kLanes<float>> segment;  ///< index into the layer; only where length >= 0
};

/// A layer's segments, patch by patch of 8 x 16 pixels.
class LayerSegments {
public:
    explicit LayerSegments(const view::SegmentLayer& layer);
    std::size_t patches() const { return across_ * down_; }
    /// In a fixed order: groups of the first segments of pixels on one side, of their second, and so on. A
    /// full group holds those of 2 x 4 pixels, which share most beams where light comes down in the picture,
    /// or, where pixels are left out, of the next ones in Morton order.
    std::vector<LayerGroup> groups(std::size_t patch) const;

private:
    static constexpr std::size_t kWide = 2, kHigh = 4;  ///< pixels of a block
    static constexpr std::size_t kSide = 4;             ///< blocks along each side of a patch
    const view::SegmentLayer& layer_;
    std::size_t across_, down_;
};

/// Directions of a sun's disc for one camera sample, in the unit disc: `count` on a spiral of equal parts
/// (Vogel 1979), turned and shrunk by the sample, so that those of a pixel's samples cover the disc evenly;
/// the middle where a pixel has one in all.
std::vector<glm::dvec2> disc_directions(int count, int sample, int samples);

}  // namespace dapple::methods::sliced_beams
