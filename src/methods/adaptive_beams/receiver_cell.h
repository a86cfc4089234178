#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "view/receiver_layer.h"

namespace dapple::methods::adaptive_beams {

/// The part of its pixel that a sample stands for (view::Camera::sample_cell).
struct ReceiverCell {
    glm::dvec2 size;   ///< pixels
    glm::dvec2 point;  ///< the sample, in cells from the cell's top left

    ReceiverCell(int sample, int samples);

    /// Pixels from the sample to the farthest corner.
    double reach() const;
    /// Of a receiver's cell on its tangent plane: vectors whose products with places there are cells to the
    /// right and down, 1/m, and in `right` its area, m^2; all 0 where the receiver has no footprint.
    void write(const view::ReceiverLayer& layer, std::size_t pixel, glm::vec4& right, glm::vec4& down) const;
};

/// Pixels from a sample to the farthest corner of its cell, at most.
double longest_reach(int samples);

}  // namespace dapple::methods::adaptive_beams
