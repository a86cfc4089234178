#include "methods/adaptive_beams/receiver_cell.h"

#include <algorithm>
#include <cmath>

#include "view/camera.h"

namespace dapple::methods::adaptive_beams {

ReceiverCell::ReceiverCell(int sample, int samples) {
    const view::Camera::SampleCell cell = view::Camera::sample_cell(sample, samples);
    size = cell.size;
    point = (view::Camera::sample_offset(sample, samples) - cell.corner) / cell.size;
}

double ReceiverCell::reach() const {
    return glm::length(size * glm::max(point, 1.0 - point));
}

void ReceiverCell::write(const view::ReceiverLayer& layer, std::size_t pixel, glm::vec4& right,
                         glm::vec4& down) const {
    right = down = glm::vec4(0);
    const glm::dvec3 normal(layer.geometric_normal[pixel]), u = size.x * glm::dvec3(layer.footprint_u[pixel]),
                                                            v = size.y * glm::dvec3(layer.footprint_v[pixel]);
    const double area = glm::dot(normal, glm::cross(u, v));
    if (!std::isfinite(area) || area == 0) return;
    right = glm::vec4(glm::cross(v, normal) / area, std::abs(area));
    down = glm::vec4(glm::cross(normal, u) / area, 0);
}

double longest_reach(int samples) {
    double longest = 0;
    for (int i = 0; i < samples; ++i) longest = std::max(longest, ReceiverCell(i, samples).reach());
    return longest;
}

}  // namespace dapple::methods::adaptive_beams
