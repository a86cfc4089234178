#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/frame_set.h"
#include "image/image.h"
#include "metrics/flicker.h"
#include "run/manifest.h"
#include "run/output_paths.h"
#include "run/stats_file.h"

namespace dapple::run {

/// Measures the luminance of the linear pictures of a folder in time while its frames are rendered, in any
/// order, and records each frame's figures in stats.jsonl as soon as its neighbours are known. Figures that
/// earlier runs recorded are kept where all their pictures are still the same. Pictures that are not at hand
/// are read again. Memory: the luminance of three pictures, whatever the length of the clip, and the
/// histograms.
class TemporalFigures {
public:
    /// `finished`: the manifest's frames, which must be up to date at every call below. `to_come`: what this
    /// run will call frame_done() for; nothing is measured before all frames that it needs have come.
    TemporalFigures(const OutputPaths& paths, const std::map<std::int64_t, FrameEntry>& finished,
                    const FrameSet& to_come);

    /// The frame has been rendered, with the primaries of its file in `linear`; or kept, where that is null.
    /// Throws Error(output_unwritable).
    void frame_done(std::int64_t frame, const image::Image* linear);

    /// Measures what is left, also of frames that this run was not asked for. False where `stop` asked to
    /// stop.
    bool complete(const std::function<bool()>& stop);
    /// Frames whose linear picture could not be had then: they and their neighbours have no figures.
    const std::set<std::int64_t>& unreadable() const { return unreadable_; }

    /// Of all finished frames that have figures.
    metrics::ClipFlicker clip() const { return metrics::clip_flicker(figures_); }

private:
    void measure_if_due(std::int64_t frame);
    void measure(std::int64_t frame, const TemporalInputs& inputs);
    /// Keeps the luminance of a picture.
    void keep(std::int64_t frame, const image::Image& linear);
    /// Lets the picture that lies farthest from the frame go where three are kept.
    void make_room(std::int64_t frame);
    /// Kept or read, of a frame beside the measured one; null where the file is not what the manifest says.
    const metrics::Picture* picture(std::int64_t frame, std::int64_t measured);

    const OutputPaths& paths_;
    const std::map<std::int64_t, FrameEntry>& finished_;
    std::set<std::int64_t> to_come_;
    std::map<std::int64_t, metrics::FrameFlicker> figures_;
    std::map<std::int64_t, TemporalInputs> inputs_;      ///< of the figures
    std::map<std::int64_t, metrics::Picture> pictures_;  ///< luminance only; three at most
    std::set<std::int64_t> unreadable_;
};

}  // namespace dapple::run
