#pragma once
#include <optional>
#include <string>
#include <vector>

#include "judge/bench_claim.h"
#include "judge/bench_runs.h"
#include "run/reporter.h"

namespace dapple::judge {

/// What was found of one row.
struct RowResult {
    enum class State {
        as_recorded,  ///< within what is expected
        changed,      ///< beyond it
        reported,     ///< nothing is expected: the figure is another on every machine
        failed,       ///< there is no figure
    };
    State state = State::failed;
    std::string failure;  ///< why there is none
    double of = 0;
    double over = 1;
    double value = 0;  ///< of / over
    /// By how much the claim holds, from 1 on, or fails, below 1: the least factor between the value and what
    /// is claimed of it. None where nothing is claimed.
    std::optional<double> margin;
};

struct ClaimResult {
    Claim claim;
    std::vector<RowResult> rows;  ///< of claim.rows
};

/// The margin of a value: of RowResult.
std::optional<double> claim_margin(const ClaimRow& row, double value);

/// "holds by 3.10", "fails by 1.20"; "–" where nothing is claimed.
std::string verdict_of(const RowResult& result);

/// Loads every run's timeline, so that faults are told before anything is rendered: of the timelines, and
/// pictures of two sizes that a row compares. Throws Error(timeline_invalid), Error(input_unreadable).
void check_runs(const Claim& claim);

/// Renders the runs of a claim into FOLDER/RUN, those with times `repeats` times, its reference into
/// REFERENCES/JOB, and measures its rows. No rows where it is interrupted.
ClaimResult judge_claim(const Claim& claim, const std::string& folder, const std::string& references,
                        int repeats, Renderings& renderings, run::Reporter& reporter);

}  // namespace dapple::judge
