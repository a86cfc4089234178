#pragma once
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Motion of a frame's pixels to the frame before, in pixels: what is at x now was at x + motion.
struct Motion {
    int width = 0;
    int height = 0;
    std::vector<float> x, y;
};

/// Warping error (Lai et al. 2018): mean over channels and visible pixels of (I_t(x) - I_(t-1)(x + m(x)))^2,
/// the earlier frame sampled bilinearly. Pixels whose source lies outside the picture, or where motion has an
/// edge (|grad m|^2 > 0.01 |m|^2 + 0.002), are left out.
struct WarpingError {
    double mean_square = 0;
    double visible_share = 0;  ///< of pixels
};

WarpingError warping_error(const Picture& before, const Picture& frame, const Motion& motion);

}  // namespace dapple::metrics
