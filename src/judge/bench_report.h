#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "judge/bench_claims.h"
#include "judge/bench_errors.h"
#include "judge/bench_hard_cases.h"
#include "judge/bench_plan.h"
#include "judge/bench_timing.h"
#include "run/job.h"

namespace dapple::judge {

/// One rung, rendered and judged.
struct RungResult {
    Rung rung;
    std::string failure;  ///< why there is nothing below; empty where there is
    Timing timing;
    std::size_t repeats = 0;
    ErrorJudge::Judged judged;
    std::optional<ClipErrors> scattered;  ///< of S, where the reference and the run have it
    std::vector<std::string> partly;      ///< what the plan did partly, with the reason
};

struct ReferenceResult {
    std::string folder, job;
    ReferenceNoise noise;
    std::optional<ReferenceNoise> scattered;  ///< of S, where the timeline scatters light
    double wall_s = 0;                        ///< a frame, with its writing
    double cpu_s = 0;
    double standard_error = 0;  ///< largest of the frames, as the method says it
    std::vector<std::string> partly;
};

/// All that a bench found.
struct BenchResult {
    std::string timeline, frames, layer;
    int width = 0, height = 0, samples = 0;
    std::vector<Ladder> ladders;
    std::vector<RungResult> rungs;
    std::optional<ReferenceResult> reference;  ///< none where only hard cases were asked for
    metrics::Exposures exposures;              ///< of HDR-FLIP
    std::vector<HardCase> hard_cases;
    std::vector<ClaimResult> claims;  ///< without a timeline; then their rows are the CSV
    run::NamedTexts provenance;
};

std::string bench_csv(const BenchResult& result);
std::string bench_json(const BenchResult& result);
std::string bench_html(const BenchResult& result);
/// The table for a terminal.
std::string bench_text(const BenchResult& result);

/// The hard cases that fail: "CASE, METHOD fails: why", with its number.
std::vector<std::string> case_failures(const BenchResult& result);

/// How the figures are defined, a sentence each.
std::vector<std::string> bench_definitions(const BenchResult& result);

}  // namespace dapple::judge
