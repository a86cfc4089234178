#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Of FrameFlicker::histogram, at most.
inline constexpr std::size_t kHistogramBins = 802;

/// Temporal figures of frame t from D at t - 1, t, t + 1, where D is the luminance I, or I - R where there is
/// a reference. Pixels that any of the pictures excludes are left out; of the mean, those of I alone. Not yet
/// divided by the clip's mean, which is known at its end.
struct FrameFlicker {
    double mean = 0;              ///< of I
    double change_before = 0;     ///< mean of |D_t - D_(t-1)|
    double change_after = 0;      ///< mean of |D_(t+1) - D_t|
    double high_pass_energy = 0;  ///< mean of H^2, H = D_t - (D_(t-1) + D_(t+1)) / 2
    /// Pixels by H^2, so that the clip's median and the share of pixels above a multiple of it can be told
    /// at the end: bin b counts 2^((b - 1) / 4 - 100) <= H^2 < 2^(b / 4 - 100), bin 0 all that is smaller,
    /// bin 801 all that is larger. It ends at the last bin that is not empty; of a lone frame it has none.
    std::vector<std::uint32_t> histogram;
    std::size_t excluded = 0;  ///< pixels
    bool operator==(const FrameFlicker&) const = default;
};

/// Only luminance and `excluded` of the pictures are used. The sizes must agree.
FrameFlicker frame_flicker(const Picture& before, const Picture& frame, const Picture& after);
/// The same of D = I - R.
FrameFlicker frame_flicker(const Picture& before, const Picture& frame, const Picture& after,
                           const Picture& reference_before, const Picture& reference,
                           const Picture& reference_after);

/// Of a frame without both neighbours: its mean, which counts in the clip's, and nothing else.
FrameFlicker lone_frame(const Picture& frame);

/// A clip's figures, from those of its frames.
struct ClipFlicker {
    double mean = 0;         ///< of I: mean over all frames, lone ones too
    double flicker = 0;      ///< mean over frames, but for lone ones, of high_pass_energy / mean^2
    double median_term = 0;  ///< clip's median of H^2: the upper end of its bin, or 0 in bin 0
    double jump_term = 0;    ///< the H^2 from which on a pixel jumps
    struct Frame {
        double flicker = 0;     ///< high_pass_energy / (clip mean)^2
        double jump_share = 0;  ///< share of pixels that jump
    };
    std::map<std::int64_t, Frame> frames;     ///< all but lone ones
    std::optional<std::int64_t> worst_frame;  ///< that of the largest flicker, the first of equal ones
};

/// A pixel jumps when its H^2 exceeds this multiple of the clip's median of H^2 (or of (1e-4 clip mean)^2,
/// where that is larger: a still clip has no jumps of rounding), both rounded up to the end of a bin of the
/// histogram, at most by 2^(1/4).
inline constexpr double kJump = 1024;

/// Frames that are missing from the map are no part of the clip. In a clip of mean 0 what flickers does so
/// infinitely.
ClipFlicker clip_flicker(const std::map<std::int64_t, FrameFlicker>& frames);

}  // namespace dapple::metrics
