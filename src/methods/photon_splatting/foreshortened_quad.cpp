#include "methods/photon_splatting/foreshortened_quad.h"

#include <cmath>

namespace dapple::methods {
namespace {

constexpr float kGrazing = 1e-4f;  // epsilon of equation 19, which is not given

}  // namespace

Footprint foreshortened_quad(const PhotonHit& hit, float area) {
    const glm::vec3 n = hit.normal;
    const float cosine = -glm::dot(hit.beam, n);
    glm::vec3 along = hit.beam + cosine * n;
    if (!(glm::dot(along, along) > 1e-12f))  // straight on: any direction of the plane
        along = glm::cross(n, std::abs(n.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0));
    along = glm::normalize(along);
    const float side = std::sqrt(area);
    Footprint footprint;
    footprint.first = (side / (cosine + kGrazing)) * along;
    footprint.second = side * glm::cross(n, along);
    return footprint;
}

}  // namespace dapple::methods
