#pragma once
#include <cstddef>

#include "metrics/picture.h"
#include "metrics/share.h"

namespace dapple::metrics {

/// Differences of a picture I to its reference R, over the three channels of all pixels that are counted.
struct Errors {
    double mean = 0;  ///< of R
    double bias = 0;  ///< mean of I - R
    double mae = 0;   ///< mean of |I - R|: L1
    double rmse = 0;  ///< root of the mean of (I - R)^2
    /// Root of the mean over blocks of 4 x 4 pixels of (mean of I - R over the block's counted pixels)^2;
    /// edge blocks as far as they go, blocks without a counted pixel left out.
    double block_rmse = 0;
    double relative_mse = 0;        ///< mean of (I - R)^2 / (R^2 + 0.01 (clip mean of R)^2)
    double psnr = 0;                ///< dB for a peak, infinite for equal pictures
    double largest = 0;             ///< of |I - R|
    std::size_t largest_pixel = 0;  ///< index of the first pixel that has it, 0 for equal pictures
    std::size_t excluded = 0;       ///< pixels

    /// The same as shares of the size of the reference's mean; infinite where there is an error but no mean.
    double relative_bias() const { return share_of(bias, mean); }
    double relative_mae() const { return share_of(mae, mean); }
    double relative_rmse() const { return share_of(rmse, mean); }
};

/// `peak`: signal range of PSNR, 1 for display-referred pictures. `clip_mean`: of R over the clip, fixed so
/// that the figure of a frame does not depend on its own mean; where it is 0 any error over black is
/// infinite. Both pictures must have one size and exclude the same pixels. Sums are in double; where no pixel
/// is counted all figures are 0 and PSNR is infinite.
Errors errors_of(const Picture& picture, const Picture& reference, double peak, double clip_mean);

}  // namespace dapple::metrics
