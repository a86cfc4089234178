#include "methods/adaptive_beams/box_reach.h"

#include <algorithm>
#include <limits>

namespace dapple::methods::adaptive_beams {

double farthest_corner(const media::Body::Place& place, const glm::dvec3& point) {
    const glm::dmat3 from_local = glm::inverse(place.turn);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 local =
            glm::mix(place.low, place.high, glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2));
        farthest = std::max(farthest, glm::distance(from_local * (local - place.shift), point));
    }
    return farthest;
}

bool may_meet(const media::Body::Place& place, const std::array<glm::dvec3, 6>& corners,
              const glm::dvec3& way) {
    const glm::dvec3 middle = 0.5 * (place.low + place.high), half = 0.5 * (place.high - place.low);
    const glm::dvec3 along = place.turn * way;
    // Apart where a plane between them is parallel to a face of the box, or to an edge of it and the way.
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 edge(0);
        edge[axis] = 1;
        for (const glm::dvec3& normal : {edge, glm::cross(edge, along)}) {
            double least = std::numeric_limits<double>::infinity(),
                   most = -std::numeric_limits<double>::infinity();
            for (const glm::dvec3& corner : corners) {
                const double at = glm::dot(normal, place.turn * corner + place.shift - middle);
                least = std::min(least, at);
                most = std::max(most, at);
            }
            const double reach = glm::dot(glm::abs(normal), half);
            if (least > reach || most < -reach) return false;
        }
    }
    return true;
}

}  // namespace dapple::methods::adaptive_beams
