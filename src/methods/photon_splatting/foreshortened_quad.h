#pragma once
#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {

/// A square of `area` m^2 across the ray, stretched along the ray's projection on the plane (Kougianos and
/// Moustakas 2021, equations 16 to 19, figure 6). In equation 16 the area is that of a cell of the map times
/// sigma^2; equations 12 and 20 spread the photon's power over it, where R lacks the cell's area as printed.
Footprint foreshortened_quad(const PhotonHit& hit, float area);

}  // namespace dapple::methods
