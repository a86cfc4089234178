#include "metrics/flicker_track.h"

#include <cassert>
#include <utility>

namespace dapple::metrics {

void FlickerTrack::add(std::int64_t frame, Picture picture, std::optional<Picture> reference) {
    assert(frames_.empty() || frames_.rbegin()->first < frame);
    frames_[frame] = lone_frame(picture);
    if (!last_.empty() && last_.back().frame != frame - 1) last_.clear();
    if (last_.size() == 2) {
        const Step& before = last_[0];
        const Step& middle = last_[1];
        assert(before.reference.has_value() == reference.has_value());
        frames_[middle.frame] = reference ? frame_flicker(before.picture, middle.picture, picture,
                                                          *before.reference, *middle.reference, *reference)
                                          : frame_flicker(before.picture, middle.picture, picture);
        last_.pop_front();
    }
    last_.push_back({frame, std::move(picture), std::move(reference)});
}

}  // namespace dapple::metrics
