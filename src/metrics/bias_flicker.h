#pragma once
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Splits the error of a clip, e_t = I_t - R_t of luminance, into what stays and what flickers: a pixel's
/// mean_t e^2 = (mean_t e)^2 + Var_t e. Frames are added in order; memory is a few planes, whatever the
/// clip's length.
class BiasFlicker {
public:
    void add(const Picture& picture, const Picture& reference);

    struct Split {
        double static_error = 0;    ///< mean over pixels of (mean_t e)^2 / mean of R^2
        double flicker_energy = 0;  ///< mean over pixels of Var_t e / mean of R^2
    };
    Split split() const;
    /// Standard deviation of e in time, a value a pixel: where it flickers.
    std::vector<float> deviation_map() const;

private:
    int frames_ = 0;
    std::vector<double> mean_, squares_;  ///< Welford's, a pixel
    double reference_energy_ = 0;         ///< sum over frames of mean R^2
};

}  // namespace dapple::metrics
