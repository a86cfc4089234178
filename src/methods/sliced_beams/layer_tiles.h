#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "methods/sliced_beams/sheet_coverage.h"
#include "scene/frame_state.h"
#include "view/receiver_layer.h"

namespace dapple::methods::sliced_beams {

/// Receivers of one tile of 8 x 8 pixels that lie on one face of an object in one medium.
struct ReceiverGroup {
    std::uint32_t object = 0;
    bool in_water = false;
    std::vector<std::size_t> pixels;
    std::vector<Receiver<float>> receivers;  ///< world axes; the footprint is the sample's cell of the pixel
    std::vector<Receiver<float>> points;     ///< the same, at the path's own point

    /// Some of them, by index.
    ReceiverGroup only(std::span<const std::size_t> indices) const;
};

/// The tiles of a layer.
class LayerTiles {
public:
    LayerTiles(const view::ReceiverLayer& layer, const scene::Clip& clip);
    std::size_t count() const { return across_ * down_; }
    /// The groups of a tile, by object and face; at most kTileReceivers receivers each.
    std::vector<ReceiverGroup> groups(std::size_t tile) const;

private:
    void add(std::size_t pixel, std::vector<ReceiverGroup>& groups) const;

    const view::ReceiverLayer& layer_;
    glm::vec2 shift_, size_;  ///< of the sample's cell: centre less the sample's offset, and size, in pixels
    std::size_t across_, down_;
};

}  // namespace dapple::methods::sliced_beams
