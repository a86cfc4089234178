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

/// Most exposures that are chosen: pixels of nearly no light would ask for any number of them.
inline constexpr int kMostExposures = 32;

/// From the reference's luminance: start = log2(x / Y_max), stop = log2(x / Y_median), x where the ACES tone
/// curve gives 0.85, count = max(2, ceil(stop - start)) (Andersson et al. 2021, section 2.1). Largest and
/// median are of all counted pixels of all pictures given, linear Rec.709; where the median is not above 0,
/// which the paper leaves open, it is that of the pixels above 0. Where there is none the exposure is 0.
/// Beyond kMostExposures the steps grow instead of their number, which the paper leaves open too.
Exposures exposures_of(const std::vector<const Picture*>& references);

struct Flip {
    double mean = 0;             ///< of the map, in [0, 1]
    double weighted_median = 0;  ///< the smallest value that, with all below it, makes half of the map's sum
    double largest = 0;
    std::vector<float> map;  ///< a value a pixel; 0 at excluded ones
};

/// Display-referred pictures: sRGB code values in [0, 1], held there. Both must have one size and exclude the
/// same pixels, which enter their neighbours' blur as black in both and no figure of their own. Computed in
/// float: values are right to 1e-5, to 5e-5 where they are below 1e-3.
Flip flip_ldr(const Picture& picture, const Picture& reference,
              double pixels_per_degree = kDefaultPixelsPerDegree);

/// Scene-linear pictures of Rec.709 primaries (to_rec709): at each pixel the largest LDR-FLIP of all
/// exposures, tone-mapped by the fit to ACES. Negative values count as 0.
Flip flip_hdr(const Picture& picture, const Picture& reference, const Exposures& exposures,
              double pixels_per_degree = kDefaultPixelsPerDegree);

/// Pictures to compare; of one size, excluding the same pixels.
struct FlipPair {
    const Picture* picture = nullptr;
    const Picture* reference = nullptr;
};

/// FLIP of each pair, the same as one by one; what a picture takes is computed once, in however many pairs it
/// stands (a frame with its reference and with the frame before it, several pictures with one reference).
std::vector<Flip> flips_ldr(const std::vector<FlipPair>& pairs,
                            double pixels_per_degree = kDefaultPixelsPerDegree);
std::vector<Flip> flips_hdr(const std::vector<FlipPair>& pairs, const Exposures& exposures,
                            double pixels_per_degree = kDefaultPixelsPerDegree);

}  // namespace dapple::metrics
