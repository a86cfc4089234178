#include "judge/bench_claims.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "image/exr.h"
#include "judge/text.h"
#include "run/output_paths.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

/// A figure that cannot be had.
struct NoFigure {
    std::string why;
};

/// Pixels of a region, by the depths that a run's frames hold.
ErrorJudge::Pixels pixels_of(const ClaimRegion& region, const run::OutputPaths& paths) {
    return [region, paths](std::int64_t frame) {
        const std::string file = paths.linear(frame);
        const image::Image image = image::read_exr(file, [](const std::string& name) { return name == "Z"; });
        const image::Channel* depth = image.find("Z");
        if (depth == nullptr) throw Error(ExitCode::input_unreadable, file + ": has no channel Z");
        std::vector<bool> pixels(image.pixels());
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const auto width = static_cast<std::size_t>(image.width);
            const double x = (static_cast<double>(i % width) + 0.5) / image.width;
            const std::size_t row = i / width;
            const double y = (static_cast<double>(row) + 0.5) / image.height;
            const auto z = static_cast<double>(depth->values[i]);
            pixels[i] = z >= region.nearest && z <= region.farthest && x >= region.box[0] &&
                        y >= region.box[1] && x <= region.box[2] && y <= region.box[3];
        }
        return pixels;
    };
}

/// What one run left.
struct Done {
    std::string folder, failure;
    std::vector<Repeat> repeats;  ///< of runs with times
};

class ClaimBench {
public:
    ClaimBench(const Claim& claim, std::string folder, std::string references, int repeats,
               Renderings& renderings, run::Reporter& reporter)
        : claim_(claim),
          folder_(std::move(folder)),
          references_(std::move(references)),
          repeats_(repeats),
          renderings_(renderings),
          reporter_(reporter) {}

    ClaimResult result() {
        ClaimResult result{claim_, {}};
        if (!render()) return result;
        reporter_.status(claim_.name + ": figures");
        for (const ClaimRow& row : claim_.rows) {
            if (renderings_.interrupted()) return {claim_, {}};
            result.rows.push_back(measure(row));
        }
        return result;
    }

private:
    /// False where it was interrupted.
    bool render() {
        std::set<std::string> timed;
        for (const ClaimRow& row : claim_.rows) {
            if (row.figure->repeats()) continue;
            timed.insert(row.of.run);
            for (const ClaimTerm& term : row.over) timed.insert(term.run);
        }
        std::vector<TimedRun> repeated;
        for (const ClaimRun* run : all_runs()) {
            const auto timeline = timeline::Timeline::load(claim_.timeline, run->overrides);
            clip_name_ = timeline.clip().name;
            samples_[run->name] = timeline.clip().samples;
            Done& done = done_[run->name];
            done.folder = run->name == kClaimReference
                              ? references_ + "/" + renderings_.job(claim_.timeline, run->overrides).hash()
                              : folder_ + "/" + run->name;
            if (timed.contains(run->name)) {
                repeated.emplace_back(claim_.name + ", " + run->name, claim_.timeline, run->overrides,
                                      claim_.frames, warm_up_frame(claim_.frames, timeline.clip()),
                                      done.folder, renderings_);
                continue;
            }
            const ProcessEnd end = renderings_.render(claim_.name + ", " + run->name, claim_.timeline,
                                                      run->overrides, claim_.frames, done.folder, false);
            if (renderings_.interrupted()) return false;
            if (!end.done()) done.failure = "exit " + std::to_string(end.exit_code) + ": " + end.error;
            reporter_.note(claim_.name + ", " + run->name + formatted(": %.1f s", end.wall_s));
        }
        if (!add_repeats(repeated, static_cast<std::size_t>(repeats_), renderings_, reporter_)) return false;
        std::size_t next = 0;
        for (const ClaimRun* run : all_runs()) {
            if (!timed.contains(run->name)) continue;
            const TimedRun& finished = repeated[next++];
            Done& done = done_[run->name];
            done.repeats = finished.repeats();
            done.failure = finished.failure();
            if (done.failure.empty() && !timing_of(done.repeats).same_bits)
                done.failure = "repeats are not the same bit by bit";
        }
        return true;
    }

    std::vector<const ClaimRun*> all_runs() const {
        std::vector<const ClaimRun*> runs;
        if (claim_.reference) runs.push_back(&*claim_.reference);
        for (const ClaimRun& run : claim_.runs) runs.push_back(&run);
        return runs;
    }

    RowResult measure(const ClaimRow& row) {
        RowResult result;
        try {
            result.of = value_of(row, row.of);
            if (!row.over.empty()) {
                double squares = 0;
                for (const ClaimTerm& term : row.over) squares += std::pow(value_of(row, term), 2);
                result.over = std::sqrt(squares);
            }
            result.value = result.of / result.over;
            if (std::isnan(result.value)) throw NoFigure{"the figure is no number"};
            result.margin = claim_margin(row, result.value);
            using enum RowResult::State;
            result.state = !row.expected ? reported
                           : result.value >= row.expected->first && result.value <= row.expected->second
                               ? as_recorded
                               : changed;
        } catch (const NoFigure& none) {
            result.failure = none.why;
        }
        return result;
    }

    const Done& done(const std::string& run) const {
        const Done& done = done_.at(run);
        if (!done.failure.empty()) throw NoFigure{run + " failed: " + done.failure};
        return done;
    }

    double value_of(const ClaimRow& row, const ClaimTerm& term) {
        switch (row.figure->kind) {
            case Figure::Kind::error:
                return error_of(row, term);
            case Figure::Kind::count:
                return count_of(row, term.run);
            case Figure::Kind::cpu:
            case Figure::Kind::wall:
                return seconds_of(row, term.run);
            case Figure::Kind::memory:
                return timing_of(done(term.run).repeats).peak_memory;
        }
        return 0;
    }

    const ErrorJudge& judge_by(const std::string& run) {
        const auto known = judges_.find(run);
        if (known != judges_.end()) return known->second;
        return judges_
            .try_emplace(run, run::OutputPaths(done(run).folder, clip_name_), claim_.frames, claim_.layer,
                         samples_.at(run))
            .first->second;
    }

    double error_of(const ClaimRow& row, const ClaimTerm& term) {
        const ErrorJudge& judge = judge_by(term.against);
        if (term.run == kClaimReference && term.against == kClaimReference) {
            const std::optional<double>& noise = judge.noise().*row.figure->noise;
            if (!noise) throw NoFigure{"the reference's noise is not known"};
            return *noise;
        }
        const auto key = std::tuple(term.run, term.against, row.region);
        auto known = errors_.find(key);
        if (known == errors_.end()) {
            const run::OutputPaths against(done(term.against).folder, clip_name_);
            ErrorJudge::Pixels pixels;
            for (const ClaimRegion& region : claim_.regions)
                if (region.name == row.region) pixels = pixels_of(region, against);
            known =
                errors_.emplace(key, judge.judge({done(term.run).folder, clip_name_}, pixels).errors).first;
        }
        if (known->second.compared == 0) throw NoFigure{"no pixel is compared"};
        return row.figure->error(known->second);
    }

    double count_of(const ClaimRow& row, const std::string& run) const {
        const run::OutputPaths paths(done(run).folder, clip_name_);
        double sum = 0;
        bool found = false;
        for (const auto& [number, frame] : read_frames(paths.stats())) {
            const auto count = frame.counts.find(row.count);
            if (count == frame.counts.end() || !std::ranges::binary_search(claim_.frames, number)) continue;
            sum += count->second;
            found = true;
        }
        if (!found) throw NoFigure{"the stats of " + run + " count no " + row.count};
        return sum;
    }

    double seconds_of(const ClaimRow& row, const std::string& run) const {
        const bool cpu = row.figure->kind == Figure::Kind::cpu;
        const Timing timing = timing_of(done(run).repeats);
        if (row.passes.empty()) return (cpu ? timing.cpu_s : timing.wall_s).median;
        double sum = 0;
        bool found = false;
        std::string names;
        for (const Timing::Pass& pass : timing.passes) {
            names += (names.empty() ? "" : ", ") + pass.name;
            if (std::ranges::find(row.passes, pass.name) == row.passes.end()) continue;
            sum += (cpu ? pass.cpu_s : pass.wall_s).median;
            found = true;
        }
        if (!found) throw NoFigure{run + " has none of these passes; it has " + names};
        return sum;
    }

    const Claim& claim_;
    std::string folder_, references_;
    int repeats_;
    Renderings& renderings_;
    run::Reporter& reporter_;
    std::string clip_name_;
    std::map<std::string, Done> done_;
    std::map<std::string, int> samples_;
    std::map<std::string, ErrorJudge> judges_;  ///< by the run that errors are against
    std::map<std::tuple<std::string, std::string, std::string>, ClipErrors> errors_;
};

}  // namespace

std::optional<double> claim_margin(const ClaimRow& row, double value) {
    std::optional<double> margin;
    if (row.at_least) margin = value / *row.at_least;
    if (row.at_most)
        margin = std::min(margin.value_or(std::numeric_limits<double>::infinity()), *row.at_most / value);
    return margin;
}

std::string verdict_of(const RowResult& result) {
    if (result.state == RowResult::State::failed) return "no figure: " + result.failure;
    if (!result.margin) return "–";
    const double margin = *result.margin;
    if (margin >= 1) return std::isinf(margin) ? "holds" : "holds by " + formatted("%.2f", margin);
    return margin > 0 ? "fails by " + formatted("%.2f", 1 / margin) : "fails";
}

void check_runs(const Claim& claim) {
    std::map<std::string, scene::Clip> clips;
    const auto load = [&](const ClaimRun& run) {
        try {
            clips[run.name] = timeline::Timeline::load(claim.timeline, run.overrides).clip();
        } catch (const timeline::TimelineError& error) {
            throw Error(ExitCode::timeline_invalid, claim.file + ": " + run.name + ": " + error.what());
        }
    };
    if (claim.reference) load(*claim.reference);
    for (const ClaimRun& run : claim.runs) load(run);
    const auto size = [&](const std::string& run) {
        return std::to_string(clips.at(run).width) + " x " + std::to_string(clips.at(run).height);
    };
    for (const ClaimRow& row : claim.rows) {
        if (row.figure->kind != Figure::Kind::error) continue;
        std::vector<ClaimTerm> terms = row.over;
        terms.insert(terms.begin(), row.of);
        for (const ClaimTerm& term : terms)
            if (size(term.run) != size(term.against))
                throw Error(ExitCode::timeline_invalid,
                            claim.file + ": " + row.says + ": " + term.run + ": " + size(term.run) +
                                " pixels; errors need the " + size(term.against) + " of " + term.against);
    }
}

ClaimResult judge_claim(const Claim& claim, const std::string& folder, const std::string& references,
                        int repeats, Renderings& renderings, run::Reporter& reporter) {
    return ClaimBench(claim, folder, references, repeats, renderings, reporter).result();
}

}  // namespace dapple::judge
