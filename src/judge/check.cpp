#include "judge/check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/error.h"
#include "base/stats.h"
#include "judge/check_findings.h"
#include "judge/check_frames.h"
#include "judge/check_pilots.h"
#include "judge/sequence_reader.h"

namespace dapple::judge {
namespace {

std::vector<std::int64_t> wanted_frames(const CheckOptions& options, const Sequence& sequence,
                                        const Sequence* reference) {
    if (!options.frames) {
        return reference != nullptr ? all_frames({sequence, *reference}) : all_frames({sequence});
    }
    std::vector<std::int64_t> frames = options.frames->frames();
    if (frames.size() > static_cast<std::size_t>(kMostFrames)) {
        throw Error(ExitCode::usage, "--frames: " + std::to_string(frames.size()) + " frames; at most " +
                                         std::to_string(kMostFrames) + " are judged");
    }
    std::ranges::sort(frames);
    return frames;
}

void check_options(const CheckOptions& options) {
    const auto& [max_flicker, max_error, max_flip, min_psnr, min_ssim] = options.limits;
    const bool against_reference = max_error || max_flip || min_psnr || min_ssim || options.delta_flip ||
                                   options.exposures || options.flip != FlipKind::automatic;
    if (options.reference.empty() && against_reference) {
        throw Error(ExitCode::usage,
                    "limits on error, FLIP, PSNR and SSIM, and the options of FLIP, need --reference");
    }
    if (options.flip == FlipKind::none && (max_flip || options.delta_flip)) {
        throw Error(ExitCode::usage, "--flip none leaves nothing for --max-flip and --delta-flip");
    }
}

void add_clip_figure(CheckResult& result, const std::string& name, bool most_is_worst,
                     const std::function<std::optional<double>(const FrameFigures&)>& figure) {
    ClipFigure clip;
    std::size_t count = 0;
    for (const FrameFigures& figures : result.frames) {
        const std::optional<double> value = figure(figures);
        if (!value) continue;
        if (count == 0 || (most_is_worst ? std::abs(*value) > std::abs(clip.worst) : *value < clip.worst)) {
            clip.worst = *value;
            clip.worst_frame = figures.frame;
        }
        clip.mean += *value;
        ++count;
    }
    if (count == 0) return;
    clip.mean /= static_cast<double>(count);
    result.clip[name] = clip;
}

template <typename Member, typename Value>
auto of(Member member, Value value) {
    return [member, value](const FrameFigures& figures) -> std::optional<double> {
        const auto& part = figures.*member;
        if (!part) return std::nullopt;
        return value(*part);
    };
}

/// The clip's relative errors are those of all counted pixels of all frames over the reference's mean there:
/// means of shares would let a dark frame decide.
void add_pooled_errors(CheckResult& result) {
    double count = 0, mean = 0, bias = 0, mae = 0, squares = 0;
    for (const FrameFigures& figures : result.frames) {
        if (!figures.errors) continue;
        const metrics::Errors& errors = *figures.errors;
        const double pixels = static_cast<double>(result.width) * result.height;
        const double counted = pixels - static_cast<double>(errors.excluded);
        count += counted;
        mean += counted * errors.mean;
        bias += counted * errors.bias;
        mae += counted * errors.mae;
        squares += counted * errors.rmse * errors.rmse;
    }
    if (!result.clip.contains("relative_rmse")) return;
    result.clip["relative_bias"].mean = metrics::share_of(bias, mean);
    result.clip["relative_mae"].mean = metrics::share_of(mae, mean);
    result.clip["relative_rmse"].mean = metrics::share_of(std::sqrt(squares * count), mean);
}

void add_clip_figures(CheckResult& result) {
    using metrics::Errors;
    using Flip = FrameFigures::Flip;
    const auto errors = &FrameFigures::errors;
    const auto flip = &FrameFigures::flip;
    add_clip_figure(result, "bias", true, of(errors, [](const Errors& e) { return e.bias; }));
    add_clip_figure(result, "mae", true, of(errors, [](const Errors& e) { return e.mae; }));
    add_clip_figure(result, "rmse", true, of(errors, [](const Errors& e) { return e.rmse; }));
    add_clip_figure(result, "block_rmse", true, of(errors, [](const Errors& e) { return e.block_rmse; }));
    add_clip_figure(result, "relative_bias", true,
                    of(errors, [](const Errors& e) { return e.relative_bias(); }));
    add_clip_figure(result, "relative_mae", true,
                    of(errors, [](const Errors& e) { return e.relative_mae(); }));
    add_clip_figure(result, "relative_rmse", true,
                    of(errors, [](const Errors& e) { return e.relative_rmse(); }));
    add_clip_figure(result, "relative_mse", true, of(errors, [](const Errors& e) { return e.relative_mse; }));
    add_clip_figure(result, "psnr", false, of(errors, [](const Errors& e) { return e.psnr; }));
    add_clip_figure(result, "ssim", false, of(&FrameFigures::ssim, [](double ssim) { return ssim; }));
    add_clip_figure(result, "flip", true, of(flip, [](const Flip& f) { return f.mean; }));
    add_clip_figure(result, "flip_weighted_median", true,
                    of(flip, [](const Flip& f) { return f.weighted_median; }));
    add_clip_figure(result, "flip_largest", true, of(flip, [](const Flip& f) { return f.largest; }));
    const auto difference = &FrameFigures::difference;
    using metrics::TemporalDifference;
    add_clip_figure(result, "difference_mae", true,
                    of(difference, [](const TemporalDifference& d) { return d.mae; }));
    add_clip_figure(result, "difference_rmse", true,
                    of(difference, [](const TemporalDifference& d) { return d.rmse; }));
    const auto delta = &FrameFigures::delta_flip;
    add_clip_figure(result, "delta_flip", true,
                    of(delta, [](const metrics::DeltaFlip& d) { return d.mean; }));
    add_clip_figure(result, "delta_flip_absolute", true,
                    of(delta, [](const metrics::DeltaFlip& d) { return d.mean_absolute; }));
    add_clip_figure(result, "warping_error", true,
                    of(&FrameFigures::warping, [](const metrics::WarpingError& w) { return w.mean_square; }));
    add_pooled_errors(result);
    // The clip's PSNR is that of its mean square error, not the mean of decibels, which one equal frame makes
    // infinite.
    const auto psnr = result.clip.find("psnr");
    if (psnr == result.clip.end()) return;
    double squares = 0;
    std::size_t count = 0;
    for (const FrameFigures& figures : result.frames) {
        if (!figures.errors) continue;
        squares += figures.errors->rmse * figures.errors->rmse;
        ++count;
    }
    const double peak = result.options.peak;
    psnr->second.mean = 10 * std::log10(peak * peak * static_cast<double>(count) / squares);
}

/// What is wrong with the first frame that could not be read, for a sequence of nothing else.
[[noreturn]] void refuse_unreadable(const Sequence& sequence, const std::vector<FrameFigures>& frames) {
    std::string why;
    for (const FrameFigures& figures : frames) {
        if (why.empty() && !figures.path.empty()) why = figures.fault;
    }
    if (why.empty()) why = "none of the frames is there";
    throw Error(ExitCode::input_unreadable, clipped("no frame of " + sequence.name + " can be read: " + why));
}

}  // namespace

CheckResult check(const CheckOptions& options) {
    check_options(options);
    const double wall_start = wall_seconds();
    const double cpu_start = cpu_seconds();
    const Sequence sequence = find_sequence(options.sequence, options.pictures);
    std::optional<Sequence> reference;
    if (!options.reference.empty()) {
        reference = find_sequence(options.reference, options.pictures);
        pair_singles(sequence, *reference);
    }
    const Sequence* reference_or_null = reference ? &*reference : nullptr;

    CheckResult result;
    result.options = options;
    ReadOptions read;
    read.layer = options.layer;
    read.motion_layer = options.motion_layer;
    read.content_hash = !sequence.expected.empty();
    read.frames = wanted_frames(options, sequence, reference_or_null);
    result.first = read.frames.front();
    result.last = read.frames.back();
    result.fps = options.fps ? *options.fps : sequence.fps.value_or(0);
    double decode_cpu_s = 0;
    Pilots pilots = read_pilots(sequence, reference_or_null, read.frames, options, decode_cpu_s);
    if (options.exposures) pilots.exposures = options.exposures;

    std::vector<Sequence> sequences{sequence};
    if (reference) sequences.push_back(*reference);
    FrameMeasurer measurer(options, pilots, result.fps);
    std::vector<Finding> findings;
    SequenceReader reader(std::move(sequences), read);
    for (std::vector<ReadFrame> step = reader.next(); !step.empty(); step = reader.next()) {
        check_file(sequence, step[0], findings);
        std::optional<ReadFrame> other;
        if (reference) other = std::move(step[1]);
        measurer.add(std::move(step[0]), std::move(other));
    }
    measurer.finish(result);
    if (std::ranges::none_of(result.frames, &FrameFigures::readable)) {
        refuse_unreadable(sequence, result.frames);
    }
    if (reference && std::ranges::none_of(result.frames, [](const FrameFigures& figures) {
            return figures.errors.has_value();
        })) {
        throw Error(ExitCode::input_unreadable,
                    clipped("no frame of " + sequence.name + " can be compared with " + reference->name +
                            ": " + measurer.found().findings.front().text));
    }
    add_clip_figures(result);
    add_findings(measurer.found(), std::move(findings), result);
    result.decode_cpu_s = decode_cpu_s + reader.decode_cpu_s();
    result.metrics_cpu_s = cpu_seconds() - cpu_start - result.decode_cpu_s;
    result.wall_s = wall_seconds() - wall_start;
    result.peak_memory = peak_memory_bytes();
    return result;
}

}  // namespace dapple::judge
