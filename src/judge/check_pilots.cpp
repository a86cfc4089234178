#include "judge/check_pilots.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "judge/sequence_reader.h"

namespace dapple::judge {
namespace {

/// Of the wanted frames that are there.
std::vector<std::int64_t> pilots_of(const Sequence& sequence, const std::vector<std::int64_t>& frames) {
    std::vector<std::int64_t> there;
    for (const std::int64_t frame : frames) {
        if (sequence.files.contains(frame)) there.push_back(frame);
    }
    return pilot_frames(there);
}

std::vector<ReadFrame> read(const Sequence& sequence, const std::vector<std::int64_t>& frames,
                            const std::string& layer, double& decode_cpu_s) {
    ReadOptions options;
    options.layer = layer;
    options.frames = frames;
    std::vector<ReadFrame> read;
    if (frames.empty()) return read;
    SequenceReader reader({sequence}, options);
    for (std::vector<ReadFrame> step = reader.next(); !step.empty(); step = reader.next()) {
        if (step[0].picture) read.push_back(std::move(step[0]));
    }
    decode_cpu_s += reader.decode_cpu_s();
    return read;
}

double mean_of(const std::vector<float>& values, std::size_t counted) {
    double sum = 0;
    for (const float value : values) sum += static_cast<double>(value);
    return counted > 0 ? sum / static_cast<double>(counted) : 0;
}

}  // namespace

std::vector<std::int64_t> pilot_frames(const std::vector<std::int64_t>& frames) {
    if (frames.empty()) return {};
    std::vector<std::int64_t> pilots{frames.front(), frames[frames.size() / 2], frames.back()};
    pilots.erase(std::unique(pilots.begin(), pilots.end()), pilots.end());
    return pilots;
}

Pilots read_pilots(const Sequence& sequence, const Sequence* reference,
                   const std::vector<std::int64_t>& frames, const CheckOptions& options,
                   double& decode_cpu_s) {
    Pilots pilots;
    for (const ReadFrame& frame : read(sequence, pilots_of(sequence, frames), options.layer, decode_cpu_s)) {
        // The largest: a clip that fades in and out has black pilots.
        pilots.level = std::max(pilots.level, mean_of(frame.picture->luminance, frame.picture->counted()));
    }
    if (reference == nullptr) return pilots;

    std::vector<ReadFrame> references =
        read(*reference, pilots_of(*reference, frames), options.layer, decode_cpu_s);
    if (references.empty()) return pilots;
    for (const ReadFrame& frame : references) {
        for (const std::vector<float>& plane : frame.picture->rgb) {
            pilots.reference_mean +=
                mean_of(plane, frame.picture->counted()) / (3 * static_cast<double>(references.size()));
        }
    }
    if (references.front().display_referred && options.flip != FlipKind::hdr) return pilots;
    std::vector<const metrics::Picture*> pictures;
    for (ReadFrame& frame : references) {
        to_rec709(frame);
        pictures.push_back(&*frame.picture);
    }
    pilots.exposures = metrics::exposures_of(pictures);
    return pilots;
}

}  // namespace dapple::judge
