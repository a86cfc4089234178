#include "methods/photon_splatting/sample_place.h"

#include <cmath>

#include "view/camera.h"

namespace dapple::methods {

SamplePlace::SamplePlace(int sample, int samples, bool at_cells)
    : sample_(view::Camera::sample_offset(sample, samples)) {
    if (!at_cells) return;
    const view::Camera::SampleCell cell = view::Camera::sample_cell(sample, samples);
    moved_ = cell.corner + 0.5 * cell.size - sample_;
}

glm::dvec2 SamplePlace::in_pixel() const {
    return sample_ + moved_;
}

glm::vec3 SamplePlace::of(const view::ReceiverLayer& layer, std::size_t pixel) const {
    const glm::vec3 point = layer.position[pixel];
    if (moved_ == glm::dvec2(0)) return point;
    const glm::vec2 by(moved_);
    const glm::vec3 place = point + by.x * layer.footprint_u[pixel] + by.y * layer.footprint_v[pixel];
    return std::isfinite(place.x + place.y + place.z) ? place : point;
}

}  // namespace dapple::methods
