#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Splits the error of a clip, e_t = I_t - R_t of luminance, into what stays and what flickers: a pixel's
/// mean_t e^2 = (mean_t e)^2 + Var_t e. Memory is a few planes, whatever the clip's length. A pixel's means
/// are over the frames in which it is counted; one that is excluded from all frames is left out.
class BiasFlicker {
public:
    /// The next frame. All must have one size, and both pictures exclude the same pixels.
    void add(const Picture& picture, const Picture& reference);

    /// Shares of the mean of R^2 over all frames and counted pixels.
    struct Split {
        double static_error = 0;    ///< mean over pixels of (mean_t e)^2 / mean of R^2
        double flicker_energy = 0;  ///< mean over pixels of Var_t e / mean of R^2
    };
    Split split() const;
    /// Standard deviation of e in time, a value a pixel: where it flickers.
    std::vector<float> deviation_map() const;

private:
    std::vector<double> mean_, squares_;  ///< Welford's, a pixel
    std::vector<std::uint32_t> counts_;   ///< frames, a pixel
    double reference_squares_ = 0;        ///< sum of R^2
    std::uint64_t counted_ = 0;           ///< its terms
};

}  // namespace dapple::metrics
