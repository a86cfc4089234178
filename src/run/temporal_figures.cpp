#include "run/temporal_figures.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "base/error.h"
#include "base/hash.h"
#include "image/exr.h"

namespace dapple::run {
namespace {

constexpr std::size_t kKeptPictures = 3;

metrics::Picture luminance_of(const image::Image& linear, const std::string& name) {
    metrics::Picture picture = metrics::picture_of(linear, "", name);
    for (std::vector<float>& plane : picture.rgb) plane = {};
    return picture;
}

/// The linear picture of a finished frame from its file, or nothing where that is not the one finished.
std::optional<metrics::Picture> read_luminance(const std::string& path, const WrittenFile& expected) {
    try {
        const std::vector<std::byte> bytes = read_whole_file(path);
        if (content_hash(bytes.data(), bytes.size()) != expected.content_hash) return std::nullopt;
        const auto beauty = [](const std::string& channel) {
            return channel == "R" || channel == "G" || channel == "B";
        };
        return luminance_of(image::decode_exr(bytes, path, beauty), path);
    } catch (const Error&) {
        return std::nullopt;
    }
}

bool same_size(const metrics::Picture& a, const metrics::Picture& b) {
    return a.width == b.width && a.height == b.height;
}

}  // namespace

TemporalFigures::TemporalFigures(const OutputPaths& paths, const std::map<std::int64_t, FrameEntry>& finished,
                                 const FrameSet& to_come)
    : paths_(paths), finished_(finished), to_come_(to_come.frames().begin(), to_come.frames().end()) {
    for (auto& [frame, record] : read_temporal_records(paths.stats(), finished)) {
        figures_[frame] = std::move(record.figures);
        inputs_[frame] = std::move(record.inputs);
    }
}

void TemporalFigures::frame_done(std::int64_t frame, const image::Image* linear) {
    to_come_.erase(frame);
    if (linear != nullptr) keep(frame, *linear);
    for (const std::int64_t near : {frame - 1, frame, frame + 1}) measure_if_due(near);
}

bool TemporalFigures::complete(const std::function<bool()>& stop) {
    to_come_.clear();
    for (const auto& [frame, entry] : finished_) {
        if (stop()) return false;
        measure_if_due(frame);
    }
    return true;
}

void TemporalFigures::measure_if_due(std::int64_t frame) {
    if (!finished_.contains(frame)) return;
    for (const std::int64_t near : {frame - 1, frame, frame + 1}) {
        if (to_come_.contains(near)) return;
    }
    const TemporalInputs inputs = temporal_inputs(finished_, frame);
    if (const auto known = inputs_.find(frame); known != inputs_.end() && known->second == inputs) return;
    figures_.erase(frame);
    inputs_.erase(frame);
    measure(frame, inputs);
}

void TemporalFigures::measure(std::int64_t frame, const TemporalInputs& inputs) {
    const metrics::Picture* middle = picture(frame, frame);
    if (middle == nullptr) return;
    TemporalRecord record{inputs, {}};
    record.figures = metrics::lone_frame(*middle);
    if (inputs.size() > 1) {
        const metrics::Picture* before = picture(frame - 1, frame);
        const metrics::Picture* after = picture(frame + 1, frame);
        if (before == nullptr || after == nullptr) return;
        // A picture of another size is no neighbour.
        if (same_size(*before, *middle) && same_size(*after, *middle)) {
            record.figures = metrics::frame_flicker(*before, *middle, *after);
        }
    }
    append_stats(paths_.stats(), temporal_line(frame, record));
    figures_[frame] = std::move(record.figures);
    inputs_[frame] = std::move(record.inputs);
}

void TemporalFigures::keep(std::int64_t frame, const image::Image& linear) {
    pictures_.erase(frame);
    metrics::Picture luminance = luminance_of(linear, paths_.linear(frame));
    // The file holds 0 for what is not finite: where that happens it is read again.
    if (!luminance.excluded.empty()) return;
    make_room(frame);
    pictures_[frame] = std::move(luminance);
}

void TemporalFigures::make_room(std::int64_t frame) {
    if (pictures_.size() < kKeptPictures) return;
    const auto distance = [&](const auto& kept) { return std::abs(kept.first - frame); };
    pictures_.erase(std::ranges::max_element(pictures_, {}, distance));
}

const metrics::Picture* TemporalFigures::picture(std::int64_t frame, std::int64_t measured) {
    if (const auto kept = pictures_.find(frame); kept != pictures_.end()) return &kept->second;
    make_room(measured);
    std::optional<metrics::Picture> read = read_luminance(paths_.linear(frame), finished_.at(frame).linear);
    if (!read) {
        unreadable_.insert(frame);
        return nullptr;
    }
    return &(pictures_[frame] = std::move(*read));
}

}  // namespace dapple::run
