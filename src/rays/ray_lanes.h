#pragma once
#include <limits>

#include "base/lane_vectors.h"

namespace dapple::rays {

/// Eight rays, a lane each; otherwise as Ray.
struct RayLanes {
    lanes::Vectors3 origin, direction;
    lanes::Lanes<float> near{}, far = lanes::splat(std::numeric_limits<float>::infinity());
    lanes::Mask<float> on{};  ///< the others hit nothing
};

/// What they hit first.
struct HitLanes {
    /// In lengths of the ray's direction.
    lanes::Lanes<float> distance = lanes::splat(std::numeric_limits<float>::infinity());
    lanes::Mask<float> hit{};
    lanes::Vectors3 normal{
        {}, lanes::splat(1.0f), {}};  ///< geometric, not normalised, outward; (0, 1, 0) where nothing was hit
};

}  // namespace dapple::rays
