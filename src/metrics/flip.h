#pragma once
#include <vector>

#include "metrics/picture.h"

/// FLIP, the perceived difference of two pictures when one flips between them: Andersson et al. 2020 (LDR),
/// 2021 (HDR).
namespace dapple::metrics {

/// 0.7 m from a display of 0.7 m and 3840 pixels across: distance pixels / width pi / 180.
inline constexpr double kDefaultPixelsPerDegree = 0.7 * 3840 / 0.7 * 3.14159265358979323846 / 180;

/// Exposures in stops of HDR-FLIP: start, start + step, ..., stop. Fixed for a clip, or else the metric
/// itself flickers.
struct Exposures {
    double start = 0;
    double stop = 0;
    int count = 2;  ///< at least 2
};

/// From the reference's luminance: start = log2(x / Y_max), stop = log2(x / Y_median), x where the ACES tone
/// curve gives 0.85, count = max(2, ceil(stop - start)) (Andersson et al. 2021, section 3). The median is of
/// pixels above 0, and Y_max is the largest of all pictures given; a black clip has exposure 0.
Exposures exposures_of(const std::vector<const Picture*>& references);

struct Flip {
    double mean = 0;             ///< of the map, in [0, 1]
    double weighted_median = 0;  ///< of the map, each value weighted by itself
    double largest = 0;
    std::vector<float> map;  ///< a value a pixel
};

/// Display-referred pictures: sRGB code values in [0, 1], held there.
Flip flip_ldr(const Picture& picture, const Picture& reference,
              double pixels_per_degree = kDefaultPixelsPerDegree);

/// Scene-linear pictures of Rec.709 primaries: the largest LDR-FLIP of all exposures.
Flip flip_hdr(const Picture& picture, const Picture& reference, const Exposures& exposures,
              double pixels_per_degree = kDefaultPixelsPerDegree);

}  // namespace dapple::metrics
