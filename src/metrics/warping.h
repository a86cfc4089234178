#pragma once
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Motion of a frame's pixels to the frame before, in pixels: what is at x now was at x + motion. x runs to
/// the right, y downwards, both row-major planes of the picture's size.
struct Motion {
    int width = 0;
    int height = 0;
    std::vector<float> x, y;
};

/// Warping error (Lai et al. 2018), with motion that is known instead of estimated: mean over channels and
/// visible pixels of (I_t(x) - I_(t-1)(x + m(x)))^2, the earlier frame sampled bilinearly. A pixel is not
/// visible where its source lies outside the picture, where motion has an edge (|grad m|^2 > 0.01 |m|^2 +
/// 0.002, central differences: Sundaram et al. 2010), where motion is not finite, and where it or a pixel of
/// its source is excluded.
struct WarpingError {
    double mean_square = 0;    ///< 0 where no pixel is visible
    double visible_share = 0;  ///< of all pixels
};

/// The sizes must agree.
WarpingError warping_error(const Picture& before, const Picture& frame, const Motion& motion);

}  // namespace dapple::metrics
