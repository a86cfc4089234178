#include "judge/check_frames.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"

namespace dapple::judge {
namespace {

constexpr std::size_t kTilePixels = 1 << 14;

std::string hash_of(const metrics::Picture& picture) {
    std::string hashes;
    for (const std::vector<float>& plane : picture.rgb) {
        hashes += content_hash(plane.data(), plane.size() * sizeof(float));
    }
    return hashes + std::to_string(picture.excluded.size());
}

double mean_luminance(const metrics::Picture& picture) {
    double sum = 0;
    for (const float value : picture.luminance) sum += static_cast<double>(value);
    return picture.counted() > 0 ? sum / static_cast<double>(picture.counted())
                                 : std::numeric_limits<double>::quiet_NaN();
}

Pixel place_of(std::size_t index, int width) {
    return {static_cast<int>(index % static_cast<std::size_t>(width)),
            static_cast<int>(index / static_cast<std::size_t>(width))};
}

Box bounds_of(const std::vector<std::uint32_t>& pixels, int width) {
    const Pixel first = place_of(pixels.front(), width);
    int left = first.x, right = first.x, bottom = first.y;
    for (const std::uint32_t pixel : pixels) {
        const Pixel place = place_of(pixel, width);
        left = std::min(left, place.x);
        right = std::max(right, place.x);
        bottom = std::max(bottom, place.y);
    }
    return {left, first.y, right - left + 1, bottom - first.y + 1};
}

std::string size_of(const metrics::Picture& picture) {
    return std::to_string(picture.width) + " x " + std::to_string(picture.height);
}

metrics::Picture in_rec709(const ReadFrame& frame) {
    metrics::Picture picture = *frame.picture;
    if (frame.chromaticities) metrics::change_primaries(picture, *frame.chromaticities, metrics::kRec709);
    return picture;
}

/// As FLIP takes it: LDR-FLIP the values as code values of a display, HDR-FLIP linear Rec.709.
metrics::Picture for_flip(const ReadFrame& frame, FlipKind kind) {
    return kind == FlipKind::ldr ? *frame.picture : in_rec709(frame);
}

}  // namespace

FrameMeasurer::FrameMeasurer(const CheckOptions& options, const Pilots& pilots, double fps)
    : options_(options), pilots_(pilots), bands_(fps > 0 ? fps : 1) {}

FrameMeasurer::~FrameMeasurer() = default;

void FrameMeasurer::check_values(const ReadFrame& frame, FindingKind kind, const std::string& whose) {
    const std::vector<std::uint32_t>& pixels = frame.picture->excluded;
    if (pixels.empty()) return;
    const Pixel first = place_of(pixels.front(), frame.picture->width);
    found_.findings.push_back({kind, frame.frame, std::nullopt, bounds_of(pixels, frame.picture->width),
                               whose + std::to_string(pixels.size()) +
                                   (pixels.size() == 1 ? " pixel is" : " pixels are") +
                                   " not finite (NaN or infinite), the first at (" + std::to_string(first.x) +
                                   ", " + std::to_string(first.y) + ")"});
}

/// Whether frame and reference can be compared; what hinders it is a finding.
void FrameMeasurer::pair(Step& step) {
    const ReadFrame& frame = step.frame;
    // A frame without a pixel that counts is none.
    step.whole = frame.picture && frame.picture->counted() > 0;
    if (!step.reference) return;
    ReadFrame& reference = *step.reference;
    const auto refuse = [&](FindingKind kind, const std::string& text) {
        step.whole = false;
        found_.findings.push_back({kind, frame.frame, std::nullopt, std::nullopt, text});
    };
    if (!reference.picture) {
        return refuse(FindingKind::reference,
                      reference.missing ? "the reference lacks it" : "the reference: " + reference.fault);
    }
    check_values(reference, FindingKind::reference, "the reference: ");
    if (!step.whole) return;
    if (frame.picture->width != reference.picture->width ||
        frame.picture->height != reference.picture->height) {
        return refuse(FindingKind::reference, "is " + size_of(*frame.picture) + " pixels, the reference " +
                                                  size_of(*reference.picture));
    }
    if (frame.display_referred != reference.display_referred) {
        throw Error(
            ExitCode::usage,
            clipped(frame.path + " is " + (frame.display_referred ? "display-referred" : "scene-linear") +
                    " and " + reference.path + " is not: compare pictures of one kind"));
    }
    metrics::exclude_together(*step.frame.picture, *reference.picture);
    step.whole = frame.picture->counted() > 0;
}

void FrameMeasurer::check_repeat(Step& step) {
    step.hash = hash_of(*step.frame.picture);
    if (step.reference && step.reference->picture) step.reference_hash = hash_of(*step.reference->picture);
    const auto [same, is_new] = hashes_.emplace(step.hash, step.frame.frame);
    if (!is_new) found_.same.emplace(step.frame.frame, same->second);
}

void FrameMeasurer::measure_errors(Step& step) {
    FrameFigures& figures = figures_[step.figures];
    const metrics::Picture& picture = *step.frame.picture;
    const metrics::Picture& reference = *step.reference->picture;
    figures.reference_mean = mean_luminance(reference);
    figures.errors = metrics::errors_of(picture, reference, options_.peak, pilots_.reference_mean);
    figures.ssim = metrics::ssim(picture, reference, {options_.ssim, options_.peak});
    if (figures.errors->largest > 0) {
        figures.shift = find_shift(picture, reference, pilots_.level);
    }
    bias_.add(picture, reference);
    compared_ = true;
}

/// FLIP to the reference; where delta-FLIP is asked for, of the changes since the frame before as well, all
/// in one call, which prepares each picture once.
void FrameMeasurer::measure_flip(const Step* before, Step& step) {
    if (flip_kind_ == FlipKind::automatic) {
        flip_kind_ = options_.flip != FlipKind::automatic
                         ? options_.flip
                         : (step.frame.display_referred ? FlipKind::ldr : FlipKind::hdr);
    }
    if (flip_kind_ == FlipKind::none) return;
    if (flip_kind_ == FlipKind::hdr && !pilots_.exposures) {  // no pilot could be read
        const metrics::Picture reference = in_rec709(*step.reference);
        pilots_.exposures = metrics::exposures_of({&reference});
    }
    const metrics::Picture frame = for_flip(step.frame, flip_kind_);
    const metrics::Picture reference = for_flip(*step.reference, flip_kind_);
    std::vector<metrics::FlipPair> pairs{{&frame, &reference}};
    metrics::Picture frame_before, reference_before, frame_together, reference_together;
    const bool delta = options_.delta_flip && before != nullptr && before->whole;
    if (delta) {
        frame_before = for_flip(before->frame, flip_kind_);
        reference_before = for_flip(*before->reference, flip_kind_);
        const metrics::Picture* frame_now = &frame;
        const metrics::Picture* reference_now = &reference;
        if (frame.excluded != frame_before.excluded) {
            // The figure to the reference must not depend on what the frame before excludes.
            metrics::exclude_together(frame_together = frame, frame_before);
            metrics::exclude_together(reference_together = reference, reference_before);
            frame_now = &frame_together;
            reference_now = &reference_together;
        }
        pairs.push_back({frame_now, &frame_before});
        pairs.push_back({reference_now, &reference_before});
    }
    const std::vector<metrics::Flip> flips =
        flip_kind_ == FlipKind::ldr
            ? metrics::flips_ldr(pairs, options_.pixels_per_degree)
            : metrics::flips_hdr(pairs, *pilots_.exposures, options_.pixels_per_degree);
    const metrics::Flip& flip = flips.front();
    const auto worst = static_cast<std::size_t>(std::ranges::max_element(flip.map) - flip.map.begin());
    FrameFigures& figures = figures_[step.figures];
    figures.flip = {flip.mean, flip.weighted_median, flip.largest, place_of(worst, width_)};
    if (delta) figures.delta_flip = metrics::delta_flip(flips[1].map, flips[2].map, frame_before.excluded);
}

/// What takes the frame before and this one.
void FrameMeasurer::measure_changes(Step& before, Step& step) {
    FrameFigures& figures = figures_[step.figures];
    if (step.frame.motion) {
        figures.warping =
            metrics::warping_error(*before.frame.picture, *step.frame.picture, *step.frame.motion);
    }
    if (!step.reference) return;
    figures.difference = metrics::temporal_difference(*before.frame.picture, *step.frame.picture,
                                                      *before.reference->picture, *step.reference->picture);
}

/// What takes both neighbours: of the frame before the newest.
void FrameMeasurer::measure_middle() {
    const Step& before = steps_[0];
    const Step& step = steps_[1];
    const Step& after = steps_[2];
    if (!before.whole || !step.whole || !after.whole) return;
    const metrics::FrameFlicker flicker =
        step.reference
            ? metrics::frame_flicker(*before.frame.picture, *step.frame.picture, *after.frame.picture,
                                     *before.reference->picture, *step.reference->picture,
                                     *after.reference->picture)
            : metrics::frame_flicker(*before.frame.picture, *step.frame.picture, *after.frame.picture);
    figures_[step.figures].temporal = flicker;
    flicker_[step.frame.frame] = flicker;
    add_to_deviation(before, step, after);
}

void FrameMeasurer::add_to_deviation(const Step& before, const Step& step, const Step& after) {
    deviation_.resize(step.frame.picture->pixels());
    ++deviations_;
    const auto value = [](const Step& at, std::size_t i) {
        const float luminance = at.frame.picture->luminance[i];
        return at.reference ? luminance - at.reference->picture->luminance[i] : luminance;
    };
    std::vector<std::uint32_t> skipped;
    for (const Step* at : {&before, &step, &after}) {
        skipped.insert(skipped.end(), at->frame.picture->excluded.begin(), at->frame.picture->excluded.end());
    }
    std::vector<double> kept;
    kept.reserve(skipped.size());
    for (const std::uint32_t i : skipped) kept.push_back(deviation_[i]);
    parallel_for(deviation_.size(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float high = value(step, i) - (value(before, i) + value(after, i)) / 2;
            deviation_[i] += static_cast<double>(high * high);
        }
    });
    for (std::size_t k = 0; k < skipped.size(); ++k) deviation_[skipped[k]] = kept[k];
}

void FrameMeasurer::add_to_finder(const Step& step, bool repeat) {
    if (!step.whole) {
        if (finder_) finder_->add_gap(step.frame.frame);
        return;
    }
    if (!finder_) {
        if (pilots_.level <= 0) return;  // black so far
        finder_ = std::make_unique<JumpFinder>(width_, height_, pilots_.level);
    }
    const metrics::Picture* reference = step.reference ? &*step.reference->picture : nullptr;
    if (repeat) {
        finder_->add_repeat(step.frame.frame, *step.frame.picture, reference);
    } else {
        finder_->add(step.frame.frame, *step.frame.picture, reference);
    }
}

/// The frame does not follow the one before: numbers are left out.
void FrameMeasurer::begin_anew(std::int64_t frame) {
    steps_.clear();
    bands_.gap();
    if (finder_) finder_->add_gap(frame - 1);
}

void FrameMeasurer::add(ReadFrame frame, std::optional<ReadFrame> reference) {
    if (!figures_.empty() && frame.frame != figures_.back().frame + 1) begin_anew(frame.frame);
    Step step;
    step.frame = std::move(frame);
    step.reference = std::move(reference);
    step.figures = figures_.size();
    FrameFigures& figures = figures_.emplace_back();
    figures.frame = step.frame.frame;
    figures.path = step.frame.path;
    figures.fault = step.frame.fault;
    figures.bytes = step.frame.bytes;
    bool repeat = false;
    if (step.frame.picture) {
        figures.readable = true;
        figures.not_finite = step.frame.picture->excluded.size();
        width_ = step.frame.picture->width;
        height_ = step.frame.picture->height;
        display_referred_ = step.frame.display_referred;
        check_values(step.frame, FindingKind::not_finite, "");
        check_repeat(step);
    }
    pair(step);
    if (step.frame.picture) figures.mean = mean_luminance(*step.frame.picture);
    // The pilots are black, or could not be read.
    if (step.whole && pilots_.level <= 0) pilots_.level = figures.mean;
    Step* before = steps_.empty() ? nullptr : &steps_.back();
    if (before != nullptr && before->frame.picture && step.frame.picture) {
        ++found_.pairs;
        // Where the reference holds still too, nothing is wrong with a frame that does.
        repeat = step.hash == before->hash &&
                 (step.reference_hash.empty() || step.reference_hash != before->reference_hash);
        if (repeat) found_.repeats.push_back(step.frame.frame);
    }
    if (step.whole) {
        flicker_[step.frame.frame] = metrics::lone_frame(*step.frame.picture);
        std::vector<float> values = step.frame.picture->luminance;
        if (step.reference) {
            measure_errors(step);
            measure_flip(before, step);
            for (std::size_t i = 0; i < values.size(); ++i) {
                values[i] -= step.reference->picture->luminance[i];
            }
        }
        bands_.add(values, step.frame.picture->excluded);
        if (before != nullptr && before->whole) measure_changes(*before, step);
    } else {
        bands_.gap();
    }
    add_to_finder(step, repeat);
    steps_.push_back(std::move(step));
    if (steps_.size() > 3) steps_.pop_front();
    if (steps_.size() == 3) measure_middle();
}

void FrameMeasurer::finish(CheckResult& result) {
    if (finder_) found_.jumps = finder_->finish();
    result.width = width_;
    result.height = height_;
    result.display_referred = display_referred_;
    result.flip_kind = compared_ ? flip_kind_ : FlipKind::none;
    if (result.flip_kind == FlipKind::hdr) result.exposures = pilots_.exposures;
    result.level = pilots_.level;
    result.frames = std::move(figures_);
    result.flicker = metrics::clip_flicker(flicker_);
    if (!result.flicker.frames.empty()) result.bands = bands_.bands();
    if (compared_) result.split = bias_.split();
    if (deviations_ == 0) return;
    std::vector<float> deviation(deviation_.size());
    for (std::size_t i = 0; i < deviation.size(); ++i) {
        deviation[i] = static_cast<float>(std::sqrt(deviation_[i] / static_cast<double>(deviations_)));
    }
    const auto worst = std::ranges::max_element(deviation);
    result.worst_pixel = place_of(static_cast<std::size_t>(worst - deviation.begin()), width_);
    result.worst_deviation = result.flicker.mean > 0 ? static_cast<double>(*worst) / result.flicker.mean : 0;
    if (options_.maps) result.deviation = std::move(deviation);
}

}  // namespace dapple::judge
