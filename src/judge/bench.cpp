#include "judge/bench.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "base/checked_file.h"
#include "base/frame_set.h"
#include "base/suggest.h"
#include "judge/bench_claim_report.h"
#include "judge/bench_errors.h"
#include "judge/bench_hard_cases.h"
#include "judge/bench_report.h"
#include "judge/bench_runs.h"
#include "judge/text.h"
#include "run/output_paths.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

/// Pixels of 240 x 135: what a reference is usually rendered at.
constexpr double kUsualPixels = 240.0 * 135.0;

std::vector<std::int64_t> frames_of(const BenchOptions& options, const scene::Clip& clip) {
    if (!options.frames.empty()) {
        std::vector<std::int64_t> frames = FrameSet::parse(options.frames).frames();
        std::sort(frames.begin(), frames.end());
        return frames;
    }
    const std::int64_t middle = (clip.first_frame + clip.last_frame) / 2;
    const std::int64_t first = std::max(clip.first_frame, middle - 1);
    return FrameSet::range(first, std::min(clip.last_frame, first + 2)).frames();
}

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "unknown";
}

void make_folder(const std::string& folder) {
    std::error_code fault;
    std::filesystem::create_directories(folder, fault);
    if (fault) throw Error(ExitCode::output_unwritable, folder + ": cannot be made: " + fault.message());
}

/// One call of bench().
class Bench {
public:
    Bench(const BenchOptions& options, const run::Interruption& interruption, run::Reporter& reporter)
        : options_(options),
          reporter_(reporter),
          renderings_(options.threads, options.device, interruption, reporter) {}

    ExitCode run() {
        plan();
        make_folder(options_.folder);
        result_.provenance.insert(result_.provenance.begin(),
                                  {{"command", options_.command_line}, {"processor", processor_name()}});
        if (!options_.timeline.empty() && !(render_reference() && render_rungs() && judge()))
            return interrupted();
        if (!claims() || !hard_cases()) return interrupted();
        const std::string base = options_.folder + "/";
        write_file_atomically(base + "bench.csv", bench_csv(result_));
        write_file_atomically(base + "bench.json", bench_json(result_));
        write_file_atomically(base + "index.html", bench_html(result_));
        reporter_.note(bench_text(result_));
        return end();
    }

private:
    void plan() {
        refuse_what_is_not_used();
        if (!options_.hard_cases.empty()) case_files_ = yaml_files(options_.hard_cases, "--hard-cases");
        methods_ = methods_of(options_.plan);
        if (!options_.claims.empty()) {
            for (const std::string& file : claim_files(options_.claims)) {
                claims_.push_back(read_claim(file));
                check_runs(claims_.back());
            }
        }
        if (options_.timeline.empty()) return;
        plan_ = plan_bench(options_.timeline, options_.plan);
        const auto timeline = timeline::Timeline::load(options_.timeline, plan_.reference_overrides);
        clip_ = timeline.clip();
        frames_ = frames_of(options_, clip_);
        result_.timeline = options_.timeline;
        result_.frames = frames_text(frames_);
        result_.layer = options_.layer;
        result_.width = clip_.width;
        result_.height = clip_.height;
        result_.samples = clip_.samples;
        result_.ladders = plan_.ladders;
        const double pixels = static_cast<double>(clip_.width) * clip_.height;
        if (pixels > 1.5 * kUsualPixels) {
            char text[200];
            std::snprintf(
                text, sizeof text,
                "the reference at %dx%d takes about %.0f times as long as at 240x135, where a frame "
                "may take minutes: --set 'clip.resolution=[240, 135]'",
                clip_.width, clip_.height, pixels / kUsualPixels);
            reporter_.warning(text);
        }
    }

    /// What changes the timeline would change nothing of claims and hard cases, which are rendered as they
    /// are.
    void refuse_what_is_not_used() const {
        if (!options_.timeline.empty()) {
            if (options_.claims.empty()) return;
            throw Error(ExitCode::usage, "--claims name their own timelines: leave " +
                                             in_quotes(clipped(options_.timeline)) + " out");
        }
        const char* unused = !options_.plan.settings.empty()  ? "--set"
                             : !options_.plan.ladders.empty() ? "--ladder"
                             : !options_.frames.empty()       ? "--frames"
                                                              : nullptr;
        if (unused == nullptr) return;
        throw Error(ExitCode::usage, std::string(unused) +
                                         " is for a timeline, and none is named: hard cases are rendered as "
                                         "they are, and so are claims");
    }

    /// False where it was interrupted, as the two below.
    bool render_reference() {
        const run::Job job = renderings_.job(options_.timeline, plan_.reference_overrides);
        ReferenceResult& reference = result_.reference.emplace();
        reference.job = job.hash();
        reference.folder = options_.folder + "/references/" + reference.job;
        result_.provenance.insert(result_.provenance.end(), job.provenance.begin(), job.provenance.end());
        for (const auto& [name, text] : job.parts)
            if (name == "program" || name == "device type") result_.provenance.emplace_back(name, text);
        reporter_.note("reference: " + std::to_string(frames_.size()) + " frames, " + reference.folder);
        const ProcessEnd end = renderings_.render("reference", options_.timeline, plan_.reference_overrides,
                                                  frames_, reference.folder, false);
        if (!end.done()) {
            if (renderings_.interrupted()) return false;
            throw Error(end.signal != 0 ? ExitCode::failure : static_cast<ExitCode>(end.exit_code),
                        "the reference: " + end.error);
        }
        const std::string stats = reference_paths().stats();
        for (const auto& [frame, time] : read_frames(stats)) {
            if (!std::binary_search(frames_.begin(), frames_.end(), frame)) continue;
            reference.wall_s += time.wall_s / static_cast<double>(frames_.size());
            reference.cpu_s += time.cpu_s / static_cast<double>(frames_.size());
            const auto error = time.counts.find("reference standard error");
            if (error != time.counts.end())
                reference.standard_error = std::max(reference.standard_error, error->second);
        }
        reference.partly = partly(run::read_manifest(reference_paths().manifest()));
        return true;
    }

    run::OutputPaths reference_paths() const { return {result_.reference->folder, clip_.name}; }

    bool render_rungs() {
        const std::int64_t warm_up = warm_up_frame(frames_, clip_);
        for (const Rung& rung : plan_.rungs) {
            runs_.emplace_back(rung.name, options_.timeline, rung.overrides, frames_, warm_up,
                               options_.folder + "/runs/" + rung.name, renderings_);
            if (!runs_.back().repeats().empty())
                reporter_.note(rung.name + ": " + std::to_string(runs_.back().repeats().size()) +
                               " repeats kept");
        }
        return add_repeats(runs_, static_cast<std::size_t>(options_.repeats), renderings_, reporter_);
    }

    static std::vector<std::string> partly(const std::optional<run::Manifest>& manifest) {
        std::vector<std::string> reasons;
        if (!manifest) return reasons;
        for (const auto& [number, frame] : manifest->frames)
            for (const std::string& reason : frame.partly)
                if (std::find(reasons.begin(), reasons.end(), reason) == reasons.end())
                    reasons.push_back(reason);
        return reasons;
    }

    bool judge() {
        reporter_.note("errors by layer " + (options_.layer.empty() ? "R, G, B" : options_.layer));
        const ErrorJudge judge(reference_paths(), frames_, options_.layer, clip_.samples);
        result_.reference->noise = judge.noise();
        result_.exposures = judge.exposures();
        std::optional<ErrorJudge> scattered;
        if (options_.layer != kScatteredLayer &&
            has_layer(reference_paths(), frames_.front(), kScatteredLayer)) {
            scattered.emplace(reference_paths(), frames_, kScatteredLayer, clip_.samples);
            if (scattered->noise().mean > 0) {
                result_.reference->scattered = scattered->noise();
            } else {
                scattered.reset();
            }
        }
        for (std::size_t i = 0; i < runs_.size(); ++i) {
            if (renderings_.interrupted()) return false;
            RungResult& result = result_.rungs.emplace_back();
            result.rung = plan_.rungs[i];
            result.failure = runs_[i].failure();
            if (!result.failure.empty()) continue;
            reporter_.status("errors: " + runs_[i].name());
            result.timing = timing_of(runs_[i].repeats());
            result.repeats = runs_[i].repeats().size();
            result.partly = partly(runs_[i].manifest());
            const run::OutputPaths paths(runs_[i].folder(), clip_.name);
            result.judged = judge.judge(paths);
            if (scattered && has_layer(paths, frames_.front(), kScatteredLayer))
                result.scattered = scattered->judge(paths).errors;
        }
        return true;
    }

    static std::string note_of(const CaseVerdict& verdict) {
        std::string text = to_string(verdict.verdict) + ", " + verdict.reason;
        if (verdict.scattered)
            text += "; S " + to_string(verdict.scattered->verdict) + ", " + verdict.scattered->reason;
        return text;
    }

    bool claims() {
        for (const Claim& claim : claims_) {
            ClaimResult result =
                judge_claim(claim, options_.folder + "/claims/" + claim.name, options_.folder + "/references",
                            options_.repeats, renderings_, reporter_);
            if (renderings_.interrupted()) return false;
            result_.claims.push_back(std::move(result));
        }
        return true;
    }

    bool hard_cases() {
        if (!case_files_.empty() && !options_.plan.settings.empty())
            reporter_.note("hard cases are rendered as they are, without --set");
        for (const std::string& file : case_files_) {
            const std::string name = std::filesystem::path(file).stem().string();
            HardCase judged =
                judge_hard_case(file, methods_, options_.folder + "/hard_cases/" + name, renderings_);
            if (renderings_.interrupted()) return false;
            for (const CaseVerdict& verdict : judged.verdicts)
                reporter_.note(name + ", " + verdict.method + ": " + note_of(verdict));
            result_.hard_cases.push_back(std::move(judged));
        }
        return true;
    }

    ExitCode interrupted() {
        reporter_.run_ended(static_cast<int>(ExitCode::interrupted),
                            "interrupted; the same command goes on: " + options_.folder);
        return ExitCode::interrupted;
    }

    ExitCode end() {
        std::size_t failed = 0, bits = 0;
        for (const RungResult& rung : result_.rungs) {
            failed += rung.failure.empty() ? 0 : 1;
            bits += rung.failure.empty() && !rung.timing.same_bits ? 1 : 0;
        }
        const std::vector<std::string> cases = case_failures(result_);
        const std::vector<std::string> rows = claim_failures(result_.claims);
        const bool good = failed + bits + cases.size() + rows.size() == 0;
        std::string text =
            "report " + options_.folder + "/index.html, in " + run::format_duration(reporter_.seconds());
        if (failed > 0) text = std::to_string(failed) + " rungs failed; " + text;
        if (bits > 0) text = std::to_string(bits) + " rungs do not repeat bit by bit; " + text;
        if (!cases.empty()) {
            const std::string more =
                cases.size() > 1 ? "; verdicts that fail: " + std::to_string(cases.size()) : std::string();
            text = cases.front() + more + "; " + text;
        }
        for (const std::string& row : rows) reporter_.warning(row);
        if (!rows.empty()) text = "rows of claims that fail: " + std::to_string(rows.size()) + "; " + text;
        const ExitCode code = good ? ExitCode::done : ExitCode::check_failed;
        reporter_.run_ended(static_cast<int>(code), text);
        return code;
    }

    const BenchOptions& options_;
    run::Reporter& reporter_;
    Renderings renderings_;
    BenchPlan plan_;
    scene::Clip clip_;
    std::vector<std::int64_t> frames_;
    std::vector<TimedRun> runs_;
    std::vector<std::string> methods_, case_files_;
    std::vector<Claim> claims_;
    BenchResult result_;
};

}  // namespace

ExitCode bench(const BenchOptions& options, const run::Interruption& interruption, run::Reporter& reporter) {
    return Bench(options, interruption, reporter).run();
}

}  // namespace dapple::judge
