#pragma once
#include <array>
#include <glm/glm.hpp>

#include "media/body.h"

namespace dapple::methods::adaptive_beams {

/// m: from a point to the farthest corner of the box of a medium. Positions as media::Body's.
double farthest_corner(const media::Body::Place& place, const glm::dvec3& point);

/// Whether a beam may meet the box of a medium: never false where the hull of its corners does, true of some
/// beside the box too. `corners`: three where it begins, three where it ends; `way`: about its direction, of
/// any length.
bool may_meet(const media::Body::Place& place, const std::array<glm::dvec3, 6>& corners,
              const glm::dvec3& way);

}  // namespace dapple::methods::adaptive_beams
