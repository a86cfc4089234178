#pragma once
#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {

/// A square of `area` m^2 across the ray, stretched along the ray's projection on the plane (Kougianos and
/// Moustakas 2021, equations 16 to 19, figure 6). In equation 16 the area is that of a cell of the innermost
/// map times q0^2 sigma^2: the s^c in sigma (equation 11) makes it a cell of the photon's own cascade, and q0
/// is the footprint's scale. Equations 12 and 20 spread the photon's power over it; as printed R lacks the
/// cell's area.
Footprints foreshortened_quad(const PhotonHits& hits, Floats area);

}  // namespace dapple::methods
