#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "view/receiver_layer.h"

namespace dapple::methods {

/// Where in its pixel E of a sample is found. Kernels that are widened by the cell that a sample stands for
/// (view::Camera::sample_cell) are seen at the cell's middle: all samples together then lie on one lattice,
/// as those of a finer picture, over which the kernels sum to their flux. At the sample's own point they
/// would not.
class SamplePlace {
public:
    /// `at_cells`: in the middles of cells; else where the camera paths of the samples are.
    SamplePlace(int sample, int samples, bool at_cells);

    glm::dvec2 in_pixel() const;  ///< pixels, from the top left
    /// The receiver moved there on its tangent plane, m; as it is where its footprint says nothing.
    glm::vec3 of(const view::ReceiverLayer& layer, std::size_t pixel) const;

private:
    glm::dvec2 sample_, moved_{0};  // pixels
};

}  // namespace dapple::methods
