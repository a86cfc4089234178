#include "judge/compare_plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "base/error.h"
#include "judge/sequence_reader.h"

namespace dapple::judge {
namespace {

std::string range_of(const Sequence& sequence) {
    return sequence.name + " has " + std::to_string(sequence.first) + " to " + std::to_string(sequence.last);
}

std::vector<std::int64_t> frames_of(const CompareOptions& options, const std::vector<Sequence>& sequences) {
    if (options.frames) {
        std::vector<std::int64_t> frames = options.frames->frames();
        std::ranges::sort(frames);
        return frames;
    }
    std::int64_t first = sequences[0].first, last = sequences[0].last;
    std::string ranges;
    for (const Sequence& sequence : sequences) {
        first = std::max(first, sequence.first);
        last = std::min(last, sequence.last);
        ranges += (ranges.empty() ? "" : ", ") + range_of(sequence);
    }
    if (first > last) {
        throw Error(ExitCode::input_unreadable, clipped("the sequences have no frame in common: " + ranges +
                                                        "; name frames by --frames"));
    }
    // A clip may have been rendered in part: what no sequence has at its ends is no gap.
    const auto anyone_has = [&](std::int64_t frame) {
        return std::ranges::any_of(sequences,
                                   [&](const Sequence& sequence) { return sequence.files.contains(frame); });
    };
    while (first < last && !anyone_has(first)) ++first;
    while (first < last && !anyone_has(last)) --last;
    return FrameSet::range(first, last).frames();
}

/// The first of the frames that can be read, without its pixels' being kept longer than needed.
ReadFrame first_readable(const Sequence& sequence, const std::vector<std::int64_t>& frames) {
    ReadOptions options;
    std::ranges::copy_if(frames, std::back_inserter(options.frames),
                         [&](std::int64_t frame) { return sequence.files.contains(frame); });
    std::string fault = "has none of the frames that are compared";
    if (!options.frames.empty()) {
        SequenceReader reader({sequence}, options);
        for (std::vector<ReadFrame> step = reader.next(); !step.empty(); step = reader.next()) {
            if (step[0].picture) return std::move(step[0]);
            fault = "has no readable frame: " + step[0].fault;
        }
    }
    throw Error(ExitCode::input_unreadable, clipped(sequence.name + ": " + fault));
}

std::string size_text(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
}

/// Size and kind of all sequences, by a frame of each.
void look_at_pictures(Comparison& comparison) {
    for (const Sequence& sequence : comparison.sequences) {
        const ReadFrame read = first_readable(sequence, comparison.frames);
        const int width = read.picture->width, height = read.picture->height;
        if (comparison.width == 0) {
            comparison.width = width;
            comparison.height = height;
        }
        if (width != comparison.width || height != comparison.height) {
            throw Error(
                ExitCode::input_unreadable,
                clipped("pictures of different sizes cannot be compared: " + comparison.sequences[0].name +
                        " is " + size_text(comparison.width, comparison.height) + ", " + sequence.name +
                        " is " + size_text(width, height)));
        }
        comparison.displayed |= read.display_referred;
        comparison.graded |= !read.display_referred;
    }
}

std::filesystem::path without_manifest(const std::string& name) {
    std::filesystem::path path = std::filesystem::path(name).lexically_normal();
    if (path.filename() == "manifest.json" && path.has_parent_path()) path = path.parent_path();
    if (!path.has_filename() && path.has_parent_path()) path = path.parent_path();  // "folder/"
    return path;
}

}  // namespace

scene::Rational exact_rate(double fps) {
    const double whole = std::round(fps);
    if (std::abs(fps - whole) < 1e-6) return {std::llround(whole), 1};
    // NTSC's rates are written with two digits or more.
    const double ntsc = std::round(fps * 1.001);
    if (std::abs(fps * 1.001 - ntsc) < 5e-3) return {std::llround(ntsc) * 1000, 1001};
    return {std::llround(fps * 1000), 1000};
}

std::vector<std::string> short_labels(const std::vector<std::string>& names) {
    constexpr int kMostParts = 16;
    std::vector<std::string> labels;
    for (int parts = 1; parts <= kMostParts; ++parts) {
        labels.clear();
        for (const std::string& name : names) {
            std::filesystem::path rest = without_manifest(name), label;
            for (int i = 0; i < parts && rest.has_filename(); ++i) {
                label = i == 0 ? rest.filename() : rest.filename() / label;
                rest = rest.parent_path();
            }
            labels.push_back(label.string());
        }
        if (std::set(labels.begin(), labels.end()).size() == labels.size()) break;
    }
    return labels;
}

std::string letter(std::size_t sequence) {
    return {static_cast<char>('A' + sequence)};
}

Comparison plan_comparison(const CompareOptions& options) {
    const std::size_t count = options.sequences.size();
    if (count < 2 || count > 4) throw Error(ExitCode::usage, "two to four sequences are compared");
    if (!options.labels.empty() && options.labels.size() != count) {
        throw Error(ExitCode::usage, std::to_string(count) + " sequences need as many labels, not " +
                                         std::to_string(options.labels.size()));
    }
    Comparison comparison;
    for (const std::string& name : options.sequences) comparison.sequences.push_back(find_sequence(name));
    comparison.labels = options.labels.empty() ? short_labels(options.sequences) : options.labels;
    comparison.frames = frames_of(options, comparison.sequences);
    comparison.first = comparison.sequences[0].first;
    std::optional<double> fps;
    for (const Sequence& sequence : comparison.sequences) {
        if (!fps) fps = sequence.fps;
    }
    comparison.fps = options.fps ? *options.fps : exact_rate(fps.value_or(24));
    look_at_pictures(comparison);
    comparison.slice_row = options.slice_row.value_or(comparison.height / 2);
    if (comparison.slice_row < 0 || comparison.slice_row >= comparison.height) {
        throw Error(ExitCode::usage, "the pictures have rows 0 to " + std::to_string(comparison.height - 1) +
                                         ", there is no row " + std::to_string(comparison.slice_row));
    }
    return comparison;
}

}  // namespace dapple::judge
