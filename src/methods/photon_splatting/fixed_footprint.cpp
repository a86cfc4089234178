#include "methods/photon_splatting/foreshortened_quad.h"

namespace dapple::methods {

/// The photon's cell of the rest plane, carried along its ray without growing or shrinking: ordinary
/// splatting.
Footprint fixed_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    Footprint footprint;
    footprint.first = grid.parallel_step(hit, GridAxis::columns);
    footprint.second = grid.parallel_step(hit, GridAxis::rows);
    return footprint;
}

/// What Kougianos and Moustakas 2021 compare photon differentials with (figure 10 d): equations 16 to 20 with
/// sigma = 1.
Footprint paper_fixed_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    return foreshortened_quad(hit, grid.cell_across_light(hit.photon));
}

}  // namespace dapple::methods
