#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {
namespace {

Footprint differences(const PhotonGrid& grid, const PhotonHit& hit, bool forward) {
    Footprint footprint;
    const bool columns = grid.step(hit, GridAxis::columns, forward, footprint.first);
    const bool rows = grid.step(hit, GridAxis::rows, forward, footprint.second);
    footprint.without_neighbors = !columns || !rows;
    return footprint;
}

}  // namespace

/// Photon difference scattering (Ouyang and Yang 2020): the neighbours' own rays, taken to the tangent plane
/// of the photon's landing point, so what the neighbours hit does not matter.
Footprint difference_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    return differences(grid, hit, false);
}

/// By the rays of the next column and row.
Footprint paper_difference_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    return differences(grid, hit, true);
}

}  // namespace dapple::methods
