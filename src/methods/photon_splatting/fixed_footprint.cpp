#include "methods/photon_splatting/foreshortened_quad.h"

namespace dapple::methods {

/// The photon's cell of the rest plane, carried along its ray without growing or shrinking: ordinary
/// splatting.
Footprints fixed_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits) {
    Footprints footprints;
    footprints.first = grid.parallel_step(photons, hits, GridAxis::columns);
    footprints.second = grid.parallel_step(photons, hits, GridAxis::rows);
    return footprints;
}

/// What Kougianos and Moustakas 2021 compare photon differentials with (figure 10 d): equations 16 to 20 with
/// sigma = 1.
Footprints paper_fixed_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits) {
    return foreshortened_quad(hits, grid.cell_across_light(photons.own));
}

}  // namespace dapple::methods
