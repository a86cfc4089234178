#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "metrics/flicker.h"
#include "metrics/picture.h"

namespace dapple::metrics {

/// Temporal figures of a clip whose pictures come one after the other. Keeps the last two. A frame whose
/// neighbour was not added is a lone one: nothing is told across a gap.
class FlickerTrack {
public:
    /// Frames ascend; pictures of neighbours have one size. All have a reference or none has.
    void add(std::int64_t frame, Picture picture, std::optional<Picture> reference = std::nullopt);

    /// Of all frames so far; the last one is lone until the next is added.
    const std::map<std::int64_t, FrameFlicker>& frames() const { return frames_; }
    ClipFlicker clip() const { return clip_flicker(frames_); }

private:
    struct Step {
        std::int64_t frame = 0;
        Picture picture;
        std::optional<Picture> reference;
    };
    std::deque<Step> last_;  ///< at most two, neighbours
    std::map<std::int64_t, FrameFlicker> frames_;
};

}  // namespace dapple::metrics
