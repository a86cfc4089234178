#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/sliced_beams/scatter_sheet.h"
#include "view/segment_layer.h"

namespace dapple::methods::sliced_beams {

/// Segments of one block of 4 x 2 pixels that follow each other in no path and lie on one side of the water:
/// what is worked on at a time.
struct LayerGroup {
    bool in_water = false;
    SegmentGroup<float> segments;
    std::array<std::uint32_t, kLanes<float>> segment;  ///< index into the layer; only where length >= 0
};

/// A layer's segments, block by block.
class LayerSegments {
public:
    explicit LayerSegments(const view::SegmentLayer& layer);
    std::size_t blocks() const { return across_ * down_; }
    /// In a fixed order: those of one side that are the first of their pixel, the second, and so on.
    std::vector<LayerGroup> groups(std::size_t block) const;

private:
    static constexpr std::size_t kWide = 4, kHigh = 2;
    const view::SegmentLayer& layer_;
    std::size_t across_, down_;
};

/// Directions of a sun's disc for one camera sample, in the unit disc: `count` on a spiral of equal parts
/// (Vogel 1979), turned and shrunk by the sample, so that those of a pixel's samples cover the disc evenly;
/// the middle where a pixel has one in all.
std::vector<glm::dvec2> disc_directions(int count, int sample, int samples);

}  // namespace dapple::methods::sliced_beams
