#pragma once
#include <cstddef>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Flicker by band of temporal frequency: the power spectrum in time of D (luminance, or its error), mean
/// over pixels, by windows of kWindow frames (Hann, half overlapped: Welch 1967), summed into octaves. Memory
/// is one window of luminance, whatever the clip's length.
class BandFlicker {
public:
    static constexpr int kWindow = 32;  ///< frames; a shorter clip is one window of its own length

    explicit BandFlicker(double fps);
    void add(const std::vector<float>& values);

    struct Band {
        double low_hz = 0;
        double high_hz = 0;
        double energy = 0;  ///< mean over pixels of the variance in time within the band
    };
    /// Octaves below half the frame rate, from low to high; the constant part belongs to none. A sine of
    /// amplitude a has energy a^2 / 2, all in its band where it lies in the middle third of it.
    std::vector<Band> bands() const;

private:
    double fps_;
};

}  // namespace dapple::metrics
