#include "judge/compare_survey.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "judge/sequence_reader.h"
#include "metrics/flicker_track.h"

namespace dapple::judge {
namespace {

/// Absolute differences by size, four bins for each power of two: exponent and first two digits of the
/// mantissa of the float.
class DifferenceHistogram {
public:
    void add(const metrics::Picture& a, const metrics::Picture& b) {
        // Excluded pixels hold 0 in their own picture alone.
        const std::vector<float> differences = difference(a, b, 1);
        for (const float value : differences) {
            if (std::isfinite(value)) ++bins_[std::bit_cast<std::uint32_t>(value) >> kShift];
        }
    }

    /// The upper end of the bin up to which `share` of all differences that are not 0 reach; 0 where there
    /// are none.
    double quantile(double share) const {
        std::uint64_t total = 0;
        for (std::size_t i = 1; i < bins_.size(); ++i) total += bins_[i];
        const double wanted = share * static_cast<double>(total);
        std::uint64_t reached = 0;
        for (std::size_t i = 1; i < bins_.size(); ++i) {
            reached += bins_[i];
            if (total > 0 && static_cast<double>(reached) >= wanted) {
                return std::bit_cast<float>(static_cast<std::uint32_t>(i + 1) << kShift);
            }
        }
        return 0;
    }

private:
    static constexpr int kShift = 21;
    std::array<std::uint64_t, std::size_t{1} << (31 - kShift)> bins_{};
};

/// Half a percent of the pixels that differ may be beyond the scale.
constexpr double kShown = 0.995;

void set_scale(Survey& survey, const Comparison& comparison, const DifferenceHistogram& histogram,
               const std::optional<double>& wanted) {
    const double mean = survey.sequences[0].clip.mean;
    if (!comparison.displayed && mean > 0) {
        survey.unit = mean;
        survey.relative = true;
    }
    const double found = histogram.quantile(kShown) / survey.unit;
    if (wanted) {
        survey.difference_full = *wanted;
    } else if (found > 0 && std::isfinite(found)) {
        survey.difference_full = round_up(found);
    }
}

void note_frame(const ReadFrame& frame, SurveyedSequence& found) {
    if (frame.missing) {
        found.missing.push_back(frame.frame);
    } else if (!frame.picture) {
        found.unreadable.emplace(frame.frame, frame.fault);
    } else {
        found.excluded += frame.picture->excluded.size();
    }
}

}  // namespace

std::vector<float> difference(const metrics::Picture& a, const metrics::Picture& b, double unit) {
    std::vector<float> out(a.luminance.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = static_cast<float>(std::abs(static_cast<double>(a.luminance[i]) - b.luminance[i]) / unit);
    }
    for (const metrics::Picture* picture : {&a, &b}) {
        for (const std::uint32_t pixel : picture->excluded)
            out[pixel] = std::numeric_limits<float>::quiet_NaN();
    }
    return out;
}

double round_up(double value) {
    const double decade = std::pow(10, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * decade >= value) return factor * decade;
    }
    return 10 * decade;
}

std::optional<Survey> survey(const Comparison& comparison, const Look& look,
                             const std::optional<double>& difference_scale, const CompareListener& listener) {
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(comparison.width);
    Survey survey;
    survey.sequences.resize(comparison.sequences.size());
    for (SurveyedSequence& found : survey.sequences) found.slice.resize(row_bytes * comparison.frames.size());
    std::vector<metrics::FlickerTrack> tracks(comparison.sequences.size());
    DifferenceHistogram histogram;

    ReadOptions options;
    options.frames = comparison.frames;
    options.size = {comparison.width, comparison.height};
    SequenceReader reader(comparison.sequences, options);
    for (std::size_t index = 0; index < comparison.frames.size(); ++index) {
        if (listener.stop()) return std::nullopt;
        const std::vector<ReadFrame> step = reader.next();
        std::optional<metrics::Picture> first;
        for (std::size_t i = 0; i < step.size(); ++i) {
            SurveyedSequence& found = survey.sequences[i];
            note_frame(step[i], found);
            if (!step[i].picture) continue;
            const std::vector<std::uint8_t> row = look.rows(step[i], comparison.slice_row, 1);
            std::ranges::copy(row, found.slice.begin() + static_cast<std::ptrdiff_t>(row_bytes * index));
            metrics::Picture light = look.light(step[i]);
            if (i == 0) {
                first = light;
            } else if (first) {
                histogram.add(*first, light);
            }
            tracks[i].add(step[i].frame, std::move(light));
        }
        listener.progress("measured", index + 1, comparison.frames.size());
    }
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        survey.sequences[i].frames = tracks[i].frames();
        survey.sequences[i].clip = tracks[i].clip();
    }
    set_scale(survey, comparison, histogram, difference_scale);
    return survey;
}

}  // namespace dapple::judge
