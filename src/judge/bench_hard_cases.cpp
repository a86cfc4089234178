#include "judge/bench_hard_cases.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>

#include "base/error.h"
#include "judge/bench_plan.h"
#include "judge/text.h"
#include "run/output_paths.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

constexpr const char* kReference = "caustics={method: reference, standard_error: 0.05, most_rays: 30}";

constexpr const char* kScatteringPass = "volume caustics";  ///< of a plan

constexpr double kWhole = 0.999;  ///< share of the reference's pixels: up to edges, where samples differ

std::string change(double share) {
    return formatted("%+.2f %%", 100 * share);
}

std::string first_comment(const std::string& file) {
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    if (!line.starts_with("#")) return "";
    return line.substr(std::min(line.find_first_not_of("# "), line.size()));
}

/// The method whose keys the timeline sets; none of one that cannot be read, as some cases are meant to be.
std::string own_method(const std::string& timeline) {
    try {
        const auto loaded = timeline::Timeline::load(timeline, {});
        return loaded.at(loaded.clip().first_frame).caustics.method;
    } catch (const Error&) {
        return "";
    }
}

/// A process of one method, and the frames it left.
struct CaseRun {
    std::string folder;
    ProcessEnd end;
    std::optional<run::Manifest> manifest;
    std::vector<std::int64_t> frames;

    std::size_t non_finite() const {
        std::size_t sum = 0;
        for (const auto& [number, frame] : manifest->frames) sum += frame.non_finite;
        return sum;
    }
    /// The passes whose names begin so that were done partly, with their reasons.
    std::string partly(std::string_view pass) const {
        std::vector<std::string> reasons;
        for (const auto& [number, frame] : manifest->frames)
            for (const std::string& reason : frame.partly)
                if (reason.starts_with(pass) &&
                    std::find(reasons.begin(), reasons.end(), reason) == reasons.end())
                    reasons.push_back(reason);
        std::string text;
        for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
        return text;
    }
    run::OutputPaths paths() const { return {folder, manifest->clip.name}; }
};

/// Counts of the stats of a clip, summed up.
std::map<std::string, double> counts_in(const run::OutputPaths& paths) {
    std::map<std::string, double> counts;
    for (const auto& [number, frame] : read_frames(paths.stats()))
        for (const auto& [name, amount] : frame.counts) counts[name] += amount;
    return counts;
}

/// Light that counts name as lost on its way, W.
double lost_in(const std::map<std::string, double>& counts) {
    double lost = 0;
    for (const auto& [name, amount] : counts)
        if (name.starts_with("lost ")) lost += amount;
    return lost;
}

/// Standard error of the light that a reference's frames scatter, a share of it: the largest.
double scattered_error(const run::OutputPaths& paths) {
    double most = 0;
    for (const auto& [number, frame] : read_frames(paths.stats())) {
        const auto found = frame.counts.find("reference volume standard error of all light");
        if (found != frame.counts.end()) most = std::max(most, found->second);
    }
    return most;
}

/// Light paths that the plan leaves out, with its reasons: lines such as "sun > water:T  no  because".
std::string left_out(const std::vector<std::string>& plan) {
    std::string text;
    for (const std::string& line : plan) {
        const std::size_t no = line.find("  no  ");
        if (line.find(" > ") > no || no == std::string::npos) continue;
        const std::size_t reason = line.find_first_not_of(' ', no + 6), path = line.find_first_not_of(' ');
        if (reason == std::string::npos) continue;
        text += (text.empty() ? "" : "; ") + line.substr(path, line.find("  ", path) - path) + ": " +
                line.substr(reason);
    }
    return text;
}

/// Verdict on a run without S: named where the plan says why.
ScatteredVerdict left_out_scattering(const std::vector<std::string>& plan) {
    ScatteredVerdict verdict{Verdict::fails, "no S: no plan says why", -1, 1};
    for (const std::string& line : plan) {
        const std::size_t pass = line.find(kScatteringPass), no = line.find("  no  ");
        if (pass == std::string::npos || no == std::string::npos) continue;
        verdict.verdict = Verdict::named;
        verdict.reason = "no S; the plan says: " + line.substr(line.find_first_not_of(' ', no + 6));
    }
    return verdict;
}

/// Verdict on a run that ended well, by a reference that did too. `plan` gives why light paths are left out.
template <class Plan>
void compare(CaseVerdict& verdict, const CaseRun& run, const ErrorJudge& judge, const Plan& plan) {
    const double tolerance = energy_tolerance(judge.noise());
    const ClipErrors errors = judge.judge(run.paths()).errors;
    verdict.energy = errors.energy;
    verdict.l1 = errors.l1;
    verdict.reason = "light " + change(errors.energy) + " of ±" + percent(tolerance) + " %, L1 " +
                     percent(errors.l1) + " %";
    if (std::abs(errors.energy) <= tolerance) {
        verdict.verdict = Verdict::holds;
        return;
    }
    // What a plan says of receivers explains light that is missing because they are left out; where the
    // method answers its light must be right. Where it answers nowhere the plan names the paths or
    // receivers that it leaves out.
    std::string why;
    if (errors.compared == 0) {
        why = left_out(plan());
        if (why.empty()) why = run.partly("");
    } else if (errors.compared < kWhole) {
        const double there = energy_tolerance(judge.noise(), errors.compared);
        const double off = energy_where_compared(errors, judge.noise());
        verdict.reason += ", where it answers " + change(off) + " of ±" + percent(there) + " %";
        if (std::abs(off) <= there) why = run.partly("");
    }
    if (why.empty()) {
        verdict.reason += ": no plan says why";
    } else {
        verdict.verdict = Verdict::named;
        verdict.reason += "; the plan says: " + why;
    }
}

/// Verdict on S. That a method knows no media is asked of its plan where there is none of it.
template <class Plan>
ScatteredVerdict scattered_of(const CaseRun& run, const ErrorJudge& judge, const ScatteredEvidence& evidence,
                              const Plan& plan) {
    if (!has_layer(run.paths(), run.frames.front(), kScatteredLayer)) return left_out_scattering(plan());
    const ScatteredVerdict verdict = judge_scattered(judge, run.paths(), evidence);
    return verdict.energy > -1 ? verdict : left_out_scattering(plan());
}

}  // namespace

double energy_tolerance(const ReferenceNoise& noise, double share) {
    const double deviation = noise.rmse.value_or(0);
    return kEnergyTolerance + (deviation > 0 ? 3 * deviation / std::sqrt(noise.pixels * share) : 0);
}

double energy_where_compared(const ClipErrors& errors, const ReferenceNoise& noise) {
    return errors.bias * std::min(1.0, errors.mean / noise.mean);
}

HardCase judge_hard_case(const std::string& timeline, const std::vector<std::string>& methods,
                         const std::string& folder, Renderings& renderings) {
    HardCase result;
    result.name = std::filesystem::path(timeline).stem().string();
    result.description = first_comment(timeline);
    const std::string own = own_method(timeline);
    const auto overrides_of = [&](const std::string& method) {
        return method == "reference" ? std::vector<std::string>{kReference} : overrides_for(method, own, {});
    };
    const auto run = [&](const std::string& method) {
        CaseRun made;
        made.folder = folder + "/" + method;
        made.end = renderings.render(result.name + ", " + method, timeline, overrides_of(method), {},
                                     made.folder, false);
        if (made.end.done()) made.manifest = run::read_manifest(made.folder + "/manifest.json");
        if (made.manifest)
            for (const auto& [number, frame] : made.manifest->frames) made.frames.push_back(number);
        return made;
    };

    const CaseRun reference = run("reference");
    if (renderings.interrupted()) return result;
    std::optional<ErrorJudge> judge, scatter_judge;
    if (reference.manifest) {
        const int samples = timeline::Timeline::load(timeline, overrides_of("reference")).clip().samples;
        judge.emplace(reference.paths(), reference.frames, "E", samples);
        if (has_layer(reference.paths(), reference.frames.front(), kScatteredLayer))
            scatter_judge.emplace(reference.paths(), reference.frames, kScatteredLayer, samples);
        const double noise = judge->noise().rmse.value_or(0);
        result.reference = judge->noise().mean > 0 ? "noise " + percent(noise) + " % a pixel" : "dark";
    } else {
        result.reference = reference.end.error;
    }
    for (const std::string& method : methods) {
        const CaseRun made = run(method);
        if (renderings.interrupted()) return result;
        CaseVerdict verdict;
        verdict.method = method;
        verdict.exit_code = made.end.exit_code;
        verdict.wall_s = made.end.wall_s;
        if (!made.manifest) {
            const bool input = made.end.exit_code == static_cast<int>(ExitCode::timeline_invalid) ||
                               made.end.exit_code == static_cast<int>(ExitCode::input_unreadable);
            const bool alike = made.end.signal == 0 && input && made.end.exit_code == reference.end.exit_code;
            if (alike) verdict.verdict = Verdict::holds;
            verdict.reason = (alike ? "refused by all, exit " : "exit ") +
                             std::to_string(made.end.exit_code) + ": " + made.end.error;
        } else {
            const std::map<std::string, double> counts = counts_in(made.paths());
            verdict.lost = lost_in(counts);
            verdict.non_finite = made.non_finite();
            if (verdict.non_finite > 0) {
                verdict.reason = std::to_string(verdict.non_finite) + " values were NaN or infinite";
            } else if (judge) {
                compare(verdict, made, *judge,
                        [&] { return renderings.plan(timeline, overrides_of(method)); });
                if (scatter_judge) {
                    const auto loaded = timeline::Timeline::load(timeline, overrides_of(method));
                    verdict.scattered = scattered_of(
                        made, *scatter_judge,
                        {scattered_error(reference.paths()), counts, made.partly(kScatteringPass),
                         [&](std::int64_t frame) { return seen_straight(loaded.at(frame)); }},
                        [&] { return renderings.plan(timeline, overrides_of(method)); });
                }
            } else {
                verdict.reason = "no reference: " + result.reference;
            }
        }
        result.verdicts.push_back(std::move(verdict));
    }
    return result;
}

}  // namespace dapple::judge
