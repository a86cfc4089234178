#include "judge/check_findings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "judge/defects_drift.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

constexpr std::size_t kMostNamed = 12;  // frames in one line

using report::short_number;

std::string percent(double share) {
    char text[40];
    std::snprintf(text, sizeof text, "%+.3g %%", 100 * share);
    return text;
}

std::string numbers_of(const std::vector<std::int64_t>& frames) {
    std::string text;
    for (std::size_t i = 0; i < std::min(frames.size(), kMostNamed); ++i) {
        text += (i > 0 ? ", " : "") + std::to_string(frames[i]);
    }
    if (frames.size() > kMostNamed) text += " and " + std::to_string(frames.size() - kMostNamed) + " more";
    return text;
}

/// Frames one after another with the same text become one finding.
std::vector<Finding> joined(std::vector<Finding> findings) {
    std::vector<Finding> runs;
    for (Finding& finding : findings) {
        if (!runs.empty() && finding.frame && !finding.region) {
            Finding& run = runs.back();
            const bool continues = run.kind == finding.kind && run.text == finding.text && run.frame &&
                                   run.last_frame.value_or(*run.frame) + 1 == *finding.frame;
            if (continues) {
                run.last_frame = finding.frame;
                continue;
            }
        }
        runs.push_back(std::move(finding));
    }
    return runs;
}

const FrameFigures* find(const CheckResult& result, std::int64_t frame) {
    const auto place = std::ranges::lower_bound(result.frames, frame, {}, &FrameFigures::frame);
    return place != result.frames.end() && place->frame == frame ? &*place : nullptr;
}

/// The share of the clip's mean by which the frame's mean (less the reference's) leaves that of its
/// neighbours.
double brightness_change(const CheckResult& result, std::int64_t frame) {
    const auto place = std::ranges::lower_bound(result.frames, frame, {}, &FrameFigures::frame);
    const auto level = [](const FrameFigures& figures) {
        return figures.mean - figures.reference_mean.value_or(0);
    };
    double around = 0;
    int count = 0;
    if (place != result.frames.begin() && std::prev(place)->readable) {
        around += level(*std::prev(place));
        ++count;
    }
    if (std::next(place) != result.frames.end() && std::next(place)->readable) {
        around += level(*std::next(place));
        ++count;
    }
    return count > 0 && result.flicker.mean > 0 ? (level(*place) - around / count) / result.flicker.mean : 0;
}

Finding finding_of(const Jump& jump, const FrameMeasurer::Found& found, const CheckResult& result) {
    Finding finding{FindingKind::jump, jump.frame, std::nullopt, std::nullopt, ""};
    const bool end =
        !result.frames.empty() && (jump.frame == result.frames.back().frame ||
                                   (result.frames.size() > 1 && jump.frame == result.frames[1].frame));
    const std::string place = jump.frame == result.frames.back().frame ? "last" : "first";
    switch (jump.kind) {
        case Jump::Kind::flash:
            finding.kind = FindingKind::flash;
            finding.text = "flashes: its mean luminance leaves that of both its neighbours by " +
                           percent(brightness_change(result, jump.frame)) + " of the clip's";
            break;
        case Jump::Kind::pop:
            finding.kind = FindingKind::pop;
            finding.region = jump.region;
            finding.text = "pops: a region differs from what it is in both neighbours";
            break;
        case Jump::Kind::step:
            finding.text = end ? "jumps: the " + place + " frame does not go with the others"
                               : "jumps: it does not continue the frame before";
            break;
        case Jump::Kind::region_step:
            finding.region = jump.region;
            finding.text = "jumps: a region does not continue the frame before";
            break;
    }
    const auto same = found.same.find(jump.frame);
    if (same != found.same.end() &&
        (finding.kind == FindingKind::flash || finding.kind == FindingKind::pop)) {
        finding.kind = FindingKind::duplicate;
        finding.region.reset();
        finding.text = "shows the picture of frame " + std::to_string(same->second);
    }
    finding.text += " (" + short_number(jump.score) + " times the threshold)";
    return finding;
}

void add_repeats(const FrameMeasurer::Found& found, CheckResult& result) {
    if (found.repeats.empty()) return;
    if (2 * found.repeats.size() > found.pairs) {
        result.notes.push_back(std::to_string(found.repeats.size()) + " of " + std::to_string(found.pairs) +
                               " frames equal the frame before: the clip stands still or holds its frames");
        return;
    }
    for (const std::int64_t frame : found.repeats) {
        result.findings.push_back({FindingKind::duplicate, frame, std::nullopt, std::nullopt,
                                   "has the same pixels as the frame before"});
    }
}

/// Frames shifted alike, one after another, are one finding. A repeated frame of moving water looks shifted
/// too, and has its own name.
std::set<std::int64_t> add_shifts(const FrameMeasurer::Found& found, CheckResult& result) {
    constexpr double kAlike = 0.25;  // pixels
    std::set<std::int64_t> shifted;
    const FrameFigures* run = nullptr;
    std::int64_t last = 0;
    const auto end_run = [&] {
        if (run == nullptr) return;
        char text[100];
        std::snprintf(text, sizeof text, "is shifted by (%.2f, %.2f) pixels against the reference",
                      run->shift->dx, run->shift->dy);
        Finding finding{FindingKind::shift, run->frame, std::nullopt, std::nullopt, text};
        if (last != run->frame) finding.last_frame = last;
        result.findings.push_back(std::move(finding));
        run = nullptr;
    };
    for (const FrameFigures& figures : result.frames) {
        const bool repeated = std::ranges::find(found.repeats, figures.frame) != found.repeats.end();
        if (!figures.shift || repeated) {
            end_run();
            continue;
        }
        shifted.insert(figures.frame);
        if (run != nullptr && (std::abs(figures.shift->dx - run->shift->dx) > kAlike ||
                               std::abs(figures.shift->dy - run->shift->dy) > kAlike)) {
            end_run();
        }
        if (run == nullptr) run = &figures;
        last = figures.frame;
    }
    end_run();
    return shifted;
}

void add_drift(const std::vector<std::int64_t>& jumps, CheckResult& result) {
    double reference_mean = 0;
    std::vector<std::pair<std::int64_t, double>> errors;
    for (const FrameFigures& figures : result.frames) {
        if (!figures.reference_mean) continue;
        reference_mean += *figures.reference_mean;
        errors.emplace_back(figures.frame, figures.mean - *figures.reference_mean);
    }
    if (reference_mean <= 0) return;
    reference_mean /= static_cast<double>(errors.size());
    for (auto& [frame, error] : errors) error /= reference_mean;
    const std::optional<Drift> drift = find_drift(errors, jumps);
    if (!drift) return;
    result.findings.push_back({FindingKind::drift, std::nullopt, std::nullopt, std::nullopt,
                               "drifts: the mean error to the reference changes by " +
                                   percent(drift->per_frame) + " a frame, " + percent(drift->total) +
                                   " over the clip"});
}

/// Frames whose figure is beyond a limit, as one finding that names the worst.
void add_limit(CheckResult& result, const std::string& what, const std::optional<double>& limit, bool most,
               const std::function<std::optional<double>(const FrameFigures&)>& figure) {
    if (!limit) return;
    std::vector<std::int64_t> frames;
    double worst = 0;
    std::int64_t worst_frame = 0;
    for (const FrameFigures& figures : result.frames) {
        const std::optional<double> value = figure(figures);
        // A figure that is no number is beyond any limit.
        if (!value || (most ? *value <= *limit : *value >= *limit)) continue;
        if (frames.empty() || (most ? *value > worst : *value < worst)) {
            worst = *value;
            worst_frame = figures.frame;
        }
        frames.push_back(figures.frame);
    }
    if (frames.empty()) return;
    result.findings.push_back({FindingKind::limit, worst_frame, std::nullopt, std::nullopt,
                               what + " is " + short_number(worst) + ", " + (most ? "above " : "below ") +
                                   short_number(*limit) +
                                   "; frames beyond the limit: " + numbers_of(frames)});
}

void add_limits(CheckResult& result) {
    const CheckLimits& limits = result.options.limits;
    using Figure = std::optional<double>;
    add_limit(result, "flicker", limits.max_flicker, true, [&](const FrameFigures& figures) -> Figure {
        const auto frame = result.flicker.frames.find(figures.frame);
        if (frame == result.flicker.frames.end()) return std::nullopt;
        return frame->second.flicker;
    });
    add_limit(result, "relative RMSE", limits.max_error, true, [](const FrameFigures& figures) -> Figure {
        if (!figures.errors) return std::nullopt;
        return figures.errors->relative_rmse();
    });
    add_limit(result, "FLIP", limits.max_flip, true, [](const FrameFigures& figures) -> Figure {
        if (!figures.flip) return std::nullopt;
        return figures.flip->mean;
    });
    add_limit(result, "PSNR", limits.min_psnr, false, [](const FrameFigures& figures) -> Figure {
        if (!figures.errors) return std::nullopt;
        return figures.errors->psnr;
    });
    add_limit(result, "SSIM", limits.min_ssim, false,
              [](const FrameFigures& figures) -> Figure { return figures.ssim; });
}

}  // namespace

const char* name_of(FindingKind kind) {
    switch (kind) {
        case FindingKind::missing:
            return "missing";
        case FindingKind::duplicate:
            return "duplicate";
        case FindingKind::damaged:
            return "damaged";
        case FindingKind::not_finite:
            return "not_finite";
        case FindingKind::flash:
            return "flash";
        case FindingKind::pop:
            return "pop";
        case FindingKind::jump:
            return "jump";
        case FindingKind::shift:
            return "shift";
        case FindingKind::drift:
            return "drift";
        case FindingKind::reference:
            return "reference";
        case FindingKind::limit:
            break;
    }
    return "limit";
}

void check_file(const Sequence& sequence, const ReadFrame& frame, std::vector<Finding>& findings) {
    const auto add = [&](FindingKind kind, const std::string& text) {
        findings.push_back({kind, frame.frame, std::nullopt, std::nullopt, text});
    };
    const auto expected = sequence.expected.find(frame.frame);
    if (frame.missing) {
        const bool entered = sequence.expected.empty() || expected != sequence.expected.end();
        return add(FindingKind::missing, entered ? "there is no file" : "it is not entered in the manifest");
    }
    if (expected != sequence.expected.end() && frame.bytes != 0) {
        const WrittenFile& entry = expected->second;
        if (frame.bytes != entry.bytes) {
            return add(FindingKind::damaged, frame.path + ": has " + std::to_string(frame.bytes) +
                                                 " bytes, the manifest says " + std::to_string(entry.bytes));
        }
        if (frame.content_hash != entry.content_hash) {
            return add(FindingKind::damaged, frame.path + ": its content is not what the manifest says");
        }
    }
    if (!frame.fault.empty()) add(FindingKind::damaged, frame.fault);
}

void add_findings(const FrameMeasurer::Found& found, std::vector<Finding> findings, CheckResult& result) {
    findings.insert(findings.end(), found.findings.begin(), found.findings.end());
    std::ranges::stable_sort(findings, [](const Finding& a, const Finding& b) {
        return std::pair(a.kind, a.frame) < std::pair(b.kind, b.frame);
    });
    result.findings = joined(std::move(findings));
    add_repeats(found, result);
    const std::set<std::int64_t> shifted = add_shifts(found, result);
    std::vector<std::int64_t> jumps;
    for (const Jump& jump : found.jumps) {
        const auto explained = [&](std::int64_t frame) {
            return shifted.contains(frame) || std::ranges::find(found.repeats, frame) != found.repeats.end();
        };
        // A frame that is shifted or repeated differs from the one after it too.
        const FrameFigures* figures = find(result, jump.frame);
        const std::int64_t before = figures != nullptr && figures != result.frames.data()
                                        ? std::prev(figures)->frame
                                        : jump.frame - 1;
        if (explained(jump.frame) || explained(before)) continue;
        result.findings.push_back(finding_of(jump, found, result));
        jumps.push_back(jump.frame);
        const bool alone = jump.kind == Jump::Kind::flash || jump.kind == Jump::Kind::pop;
        if (alone && figures != &result.frames.back()) jumps.push_back(std::next(figures)->frame);
    }
    add_drift(jumps, result);
    add_limits(result);
    std::ranges::stable_sort(result.findings, {}, &Finding::kind);
}

}  // namespace dapple::judge
