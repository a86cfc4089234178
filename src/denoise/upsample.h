#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "view/receiver_layer.h"

namespace dapple::denoise {

/// How the pixels of a coarse picture lie over those of a fine one of the same view.
struct CoarseGrid {
    int scale = 2;            ///< fine pixels a side of a coarse one
    glm::dvec2 margin{0, 0};  ///< fine pixels that the coarse picture reaches beyond the left and upper edge
    glm::dvec2 place{
        0.5, 0.5};  ///< in a pixel of either, what its value stands for: the middle of its sample's cell
};

/// A picture of E, and where it is known.
struct Irradiance {
    std::vector<glm::vec3> values;  ///< W/m^2
    std::vector<std::uint8_t> covered;
};

/// Joint bilateral upsampling (Kopf et al. 2007): each receiver of `fine` has the mean of the four coarse
/// pixels about it, by bilinear weights times edge_stop(), those that are not covered left out; where none of
/// the coarse receivers that fit is covered, it is not. Pixels without a coarse receiver that fits are
/// returned, in order; nothing is said of them.
std::vector<std::size_t> upsample(const view::ReceiverLayer& fine, const view::ReceiverLayer& coarse,
                                  const Irradiance& from, const CoarseGrid& grid, Irradiance& to);

/// Gives such pixels the E of the nearest covered pixel of a coarse picture on the same surface, at most four
/// away in x and y. Returns those that found none and stay as they are.
std::vector<std::size_t> take_nearest(const view::ReceiverLayer& fine, const view::ReceiverLayer& coarse,
                                      const Irradiance& from, const CoarseGrid& grid,
                                      std::span<const std::size_t> pixels, Irradiance& to);

}  // namespace dapple::denoise
