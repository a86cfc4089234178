#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "metrics/flip.h"
#include "metrics/picture.h"
#include "run/output_paths.h"

namespace dapple::judge {

/// Differences of a run from the reference over a clip, as shares of the reference's mean over the pixels and
/// frames that are compared; infinite where there is an error and no light in the reference. "Less noise":
/// the reference's own squared error taken out of the squares.
struct ClipErrors {
    double rmse = 0;
    double rmse_less_noise = 0;
    double l1 = 0;
    double l1_inside = 0;   ///< over pixels whose neighbours show the same surface, turned by 20 deg at most
    double block_rmse = 0;  ///< of means over 4 x 4 pixels
    double block_rmse_less_noise = 0;
    double bias = 0;
    double bias_error = 0;  ///< standard error of the bias by the reference's noise, pixels independent
    double energy = 0;      ///< light over the whole picture, covered or not, less the reference's
    double largest = 0;     ///< of a pixel's channel
    double dark = 0;        ///< share of the pixels with light that have none in the run
    /// Contrast that is left: sum over neighbours in rows and columns of |difference of luminance|, over the
    /// reference's, whose noise adds to it. 1 where there is none in either.
    double detail = 1;
    double flip = 0;  ///< HDR-FLIP of R, G, B: mean over pixels and frames
    /// Mean over frames with both neighbours and pixels of (D_t - (D_(t-1) + D_(t+1)) / 2)^2, D the
    /// difference of luminance, over the squared mean of the run's own (metrics/flicker_track.h); none where
    /// no three frames follow each other.
    std::optional<double> flicker;
    std::optional<double> flicker_less_noise;
    double mean = 0;      ///< the reference's luminance, of the pixels and frames that are compared
    double compared = 0;  ///< share of the reference's covered pixels
    double inside = 0;    ///< share of the compared pixels
};

/// A picture of the error: |difference of luminance| over the reference's mean, a value a pixel.
struct ErrorMap {
    std::int64_t frame = 0;
    int width = 0;
    int height = 0;
    std::vector<float> values;  ///< NaN where nothing is compared
};

/// What the reference is worth.
struct ReferenceNoise {
    double mean = 0;    ///< of the layer's luminance, over all covered pixels and frames
    double pixels = 0;  ///< that are covered, in all frames
    /// Root of the mean of its variance, over the mean; of pixels, from sample 0's variance as if the other
    /// samples had the same and their own light (of S of the path's first branch). None where the layer has
    /// no variance.
    std::optional<double> rmse;
    std::optional<double> l1;  ///< what this noise, normally distributed, adds at least where methods agree
};

/// S, what media scatter towards the camera of light that met something specular: a layer of all pixels, also
/// of those that see no receiver.
inline constexpr const char* kScatteredLayer = "volume_caustics";

/// Whether a frame has the layer. Throws Error(input_unreadable).
bool has_layer(const run::OutputPaths& paths, std::int64_t frame, const std::string& layer);

/// Judges runs by a reference, both of dapple's own files. Pixels count that both cover by the same share of
/// their samples; of S all.
class ErrorJudge {
public:
    /// `layer`: of the linear pictures. `samples`: camera paths a pixel. Reads all frames of the reference.
    /// Throws Error(input_unreadable).
    ErrorJudge(run::OutputPaths reference, std::vector<std::int64_t> frames, std::string layer, int samples);

    struct Judged {
        ClipErrors errors;
        ErrorMap map;  ///< of the frame in the middle of the set
    };
    /// `pixels`: of a frame, those that are looked at but for `energy`; empty: all.
    using Pixels = std::function<std::vector<bool>(std::int64_t frame)>;
    Judged judge(const run::OutputPaths& run, const Pixels& pixels = {}) const;
    const ReferenceNoise& noise() const { return noise_; }
    const metrics::Exposures& exposures() const { return exposures_; }

private:
    run::OutputPaths reference_;
    std::vector<std::int64_t> frames_;
    std::string layer_;
    std::string variance_;  ///< layer of the reference's variance; empty: it is not known
    double samples_;
    ReferenceNoise noise_;
    metrics::Exposures exposures_;
};

}  // namespace dapple::judge
