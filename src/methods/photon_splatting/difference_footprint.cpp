#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {
namespace {

Footprints differences(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits, bool forward) {
    const GridSteps columns = grid.step(photons, hits, GridAxis::columns, forward),
                    rows = grid.step(photons, hits, GridAxis::rows, forward);
    Footprints footprints;
    footprints.first = columns.on_plane;
    footprints.second = rows.on_plane;
    footprints.without_neighbors = ~(columns.any & rows.any);
    return footprints;
}

}  // namespace

/// Photon difference scattering (Ouyang and Yang 2020): the neighbours' own rays, taken to the tangent plane
/// of the photon's landing point, so what the neighbours hit does not matter.
Footprints difference_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits) {
    return differences(grid, photons, hits, false);
}

/// By the rays of the next column and row.
Footprints paper_difference_footprint(const PhotonGrid& grid, const Photons& photons,
                                      const PhotonHits& hits) {
    return differences(grid, photons, hits, true);
}

}  // namespace dapple::methods
