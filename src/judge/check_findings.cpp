#include "judge/check_findings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
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

bool alike(const Shift& a, const Shift& b) {
    constexpr double kAlike = 0.25;  // pixels
    return std::abs(a.dx - b.dx) <= kAlike && std::abs(a.dy - b.dy) <= kAlike;
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
    const bool last = jump.frame == result.frames.back().frame;
    // The change into the second frame is one out of the first.
    const bool first = !last && result.frames.size() > 1 && jump.frame == result.frames[1].frame;
    const std::string place = last ? "last" : "first";
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
            finding.text = first || last ? "jumps: the " + place + " frame does not go with the others"
                                         : "jumps: it does not continue the frame before";
            if (first) finding.frame = result.frames.front().frame;
            break;
        case Jump::Kind::region_step:
            finding.region = jump.region;
            finding.text = first ? "jumps: a region of the first frame does not go with the others"
                                 : "jumps: a region does not continue the frame before";
            if (first) finding.frame = result.frames.front().frame;
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

/// Whether the clip stands still or holds its frames, so that a repeat is no defect: more than half of the
/// frames repeat, or as good as half of them, never two in a row, as animation on twos does.
bool holds_frames(const FrameMeasurer::Found& found) {
    constexpr std::size_t kLeastPairs = 6;
    const std::size_t repeats = found.repeats.size();
    if (2 * repeats > found.pairs) return true;
    const bool in_a_row = std::ranges::adjacent_find(found.repeats, [](std::int64_t a, std::int64_t b) {
                              return b == a + 1;
                          }) != found.repeats.end();
    return found.pairs >= kLeastPairs && 2 * repeats + 1 >= found.pairs && !in_a_row;
}

void add_repeats(const FrameMeasurer::Found& found, CheckResult& result) {
    if (found.repeats.empty()) return;
    if (holds_frames(found)) {
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
void add_shifts(const FrameMeasurer::Found& found, CheckResult& result) {
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
        if (run != nullptr && !alike(*figures.shift, *run->shift)) end_run();
        if (run == nullptr) run = &figures;
        last = figures.frame;
    }
    end_run();
}

/// Whether the frame itself is where the others are not: unlike its two nearest neighbours it has no shift,
/// because it lies right, or because something else about it hides its shift. It is no consequence of theirs.
bool is_odd(const CheckResult& result, const FrameFigures& figures) {
    if (figures.shift) return false;
    const FrameFigures* before = find(result, figures.frame - 1);
    const FrameFigures* after = find(result, figures.frame + 1);
    if (before == nullptr) before = find(result, figures.frame + 2);
    if (after == nullptr) after = find(result, figures.frame - 2);
    return before != nullptr && after != nullptr && before->shift && after->shift &&
           alike(*before->shift, *after->shift);
}

/// Whether the shift changes between two frames, which then differ for that.
bool shift_changes(const CheckResult& result, std::int64_t frame) {
    const FrameFigures* before = find(result, frame - 1);
    const FrameFigures* now = find(result, frame);
    if (before == nullptr || now == nullptr || (!before->shift && !now->shift)) return false;
    if (is_odd(result, *before) || is_odd(result, *now)) return false;
    return !before->shift || !now->shift || !alike(*before->shift, *now->shift);
}

void add_drift(const std::vector<std::int64_t>& jumps, CheckResult& result) {
    constexpr double kDark = 0.1;  // of the brightest frame: darker ones tell little of the light's share
    double brightest = 0;
    for (const FrameFigures& figures : result.frames) {
        brightest = std::max(brightest, figures.reference_mean.value_or(0));
    }
    // Over each frame's own mean, so that light that is lost by a growing share is no scatter where the water
    // makes the frames differently bright.
    std::vector<std::pair<std::int64_t, double>> errors;
    for (const FrameFigures& figures : result.frames) {
        const double expected = figures.reference_mean.value_or(0);
        if (expected <= 0 || expected < kDark * brightest) continue;
        errors.emplace_back(figures.frame, (figures.mean - expected) / expected);
    }
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
    if (limits.max_flicker && result.flicker.frames.empty()) {
        result.notes.push_back("--max-flicker: no frame has both neighbours, so none was held against it");
    }
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
    add_shifts(found, result);
    std::vector<std::int64_t> jumps;
    for (const Jump& jump : found.jumps) {
        const bool alone = jump.kind == Jump::Kind::flash || jump.kind == Jump::Kind::pop;
        const auto repeated = [&](std::int64_t frame) {
            return std::ranges::find(found.repeats, frame) != found.repeats.end();
        };
        // A frame that is repeated differs from the one after it too.
        if (repeated(jump.frame) || repeated(jump.frame - 1)) continue;
        if (shift_changes(result, jump.frame) || (alone && shift_changes(result, jump.frame + 1))) continue;
        result.findings.push_back(finding_of(jump, found, result));
        jumps.push_back(jump.frame);
        if (alone) jumps.push_back(jump.frame + 1);
    }
    add_drift(jumps, result);
    add_limits(result);
    std::ranges::stable_sort(result.findings, {}, &Finding::kind);
}

}  // namespace dapple::judge
