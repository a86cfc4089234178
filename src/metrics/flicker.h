#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "metrics/picture.h"

namespace dapple::metrics {

/// Temporal figures of frame t from D at t - 1, t, t + 1, where D is the luminance I, or I - R where there is
/// a reference. Not yet divided by the clip's mean, which is known at its end.
struct FrameFlicker {
    double mean = 0;              ///< of I
    double change_before = 0;     ///< mean of |D_t - D_(t-1)|
    double change_after = 0;      ///< mean of |D_(t+1) - D_t|
    double high_pass_energy = 0;  ///< mean of H^2, H = D_t - (D_(t-1) + D_(t+1)) / 2
    /// Pixels by H^2, so that the clip's median and the share of pixels above a multiple of it can be told
    /// at the end: bin b counts 2^((b - 1) / 4 - 100) <= H^2 < 2^(b / 4 - 100), bin 0 all that is smaller.
    std::vector<std::uint32_t> histogram;
    std::size_t excluded = 0;  ///< pixels, of any of the frames
};

FrameFlicker frame_flicker(const Picture& before, const Picture& frame, const Picture& after);

/// A clip's figures, from those of its frames.
struct ClipFlicker {
    double mean = 0;         ///< of I, over the clip
    double flicker = 0;      ///< mean over frames of high_pass_energy / mean^2
    double median_term = 0;  ///< clip's median of H^2
    struct Frame {
        double flicker = 0;     ///< high_pass_energy / (clip mean)^2
        double jump_share = 0;  ///< share of pixels whose H^2 exceeds kJump times the clip's median
    };
    std::map<std::int64_t, Frame> frames;
    std::optional<std::int64_t> worst_frame;
};

/// A pixel jumps when its H^2 exceeds this multiple of the clip's median of H^2 (or of (1e-4 clip mean)^2,
/// where that is larger: a still clip has no jumps of rounding).
inline constexpr double kJump = 1024;

ClipFlicker clip_flicker(const std::map<std::int64_t, FrameFlicker>& frames);

}  // namespace dapple::metrics
