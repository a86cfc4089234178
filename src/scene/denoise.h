#pragma once

namespace dapple::scene {

enum class DenoiseFilter {
    none,
    fixed,     ///< the same radius everywhere
    adaptive,  ///< wider where caustics are dark (Kougianos and Moustakas 2021, section 3.3)
};

/// A filter over the method's irradiance E, before it is multiplied by albedo. Light does not leave its
/// surface.
struct Denoise {
    DenoiseFilter filter = DenoiseFilter::none;
    int passes = 1;            ///< each along rows, then along columns
    int radius = 5;            ///< pixels, fixed
    double threshold = 0.114;  ///< adaptive: shares of this times the weakest light's luminance are dark
    /// The paper's weights and its mean at the gathering pixel, which does not keep the sum of light.
    bool paper_faithful = false;
};

/// Pixels for which E is computed; at others it is interpolated on their surfaces.
enum class BufferScale { full, half, quarter };

}  // namespace dapple::scene
