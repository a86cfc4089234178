#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {
namespace {

constexpr float kMostCompression = 100;  // at a focus there is no bound

Floats area(Vectors3 a, Vectors3 b) {
    const Vectors3 across = cross(a, b);
    return lanes::square_root<float>(dot(across, across));
}

}  // namespace

/// No size of its own: the kernel makes it a sample's cell.
Footprints point_footprint(const PhotonGrid&, const Photons&, const PhotonHits&) {
    return {};
}

/// Gruen 2019 as Kougianos and Moustakas 2021 describe it: hit points of the rays in pixels, and the light
/// that gathers there scaled by the compression ratio, the area between rays on the water over that where
/// they land. Where beams narrow light so counts twice, by the ratio and by the number of points; flat water
/// comes out right.
Footprints paper_point_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits) {
    const GridSteps right = grid.step(photons, hits, GridAxis::columns, true),
                    up = grid.step(photons, hits, GridAxis::rows, true);
    Footprints footprints;
    footprints.without_neighbors = ~(right.any & up.any);
    const glm::mat2 texel = grid.mesh().texel;
    const Floats least = all(1e-6f * std::abs(glm::determinant(texel)));
    const Floats gain =
        area(right.on_water, up.on_water) / lanes::greater(area(right.on_plane, up.on_plane), least);
    footprints.gain = footprints.without_neighbors ? all(1.0f) : lanes::lesser(gain, all(kMostCompression));
    return footprints;
}

}  // namespace dapple::methods
