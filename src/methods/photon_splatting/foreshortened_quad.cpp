#include "methods/photon_splatting/foreshortened_quad.h"

namespace dapple::methods {
namespace {

constexpr float kGrazing = 1e-4f;  // epsilon of equation 19, which is not given

}  // namespace

Footprints foreshortened_quad(const PhotonHits& hits, Floats area) {
    const Vectors3 n = hits.normal;
    const Floats cosine = -dot(hits.beam, n);
    const Vectors3 shadow = hits.beam + cosine * n;
    // Straight on: any direction of the plane.
    const Vectors3 any =
        cross(n, choose(lanes::magnitude(n.x) < 0.7f, all(glm::vec3(1, 0, 0)), all(glm::vec3(0, 1, 0))));
    const Vectors3 along = normalized(choose(dot(shadow, shadow) > 1e-12f, shadow, any));
    const Floats side = lanes::square_root<float>(area);
    Footprints footprints;
    footprints.first = (side / (cosine + kGrazing)) * along;
    footprints.second = side * cross(n, along);
    return footprints;
}

}  // namespace dapple::methods
