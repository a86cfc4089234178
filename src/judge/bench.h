#pragma once
#include <string>
#include <vector>

#include "base/error.h"
#include "judge/bench_plan.h"
#include "run/interruption.h"
#include "run/reporter.h"

namespace dapple::judge {

struct BenchOptions {
    std::string timeline;  ///< empty: hard cases or claims only
    PlanOptions plan;
    std::string frames;       ///< as in render; empty: three consecutive ones in the middle of the clip
    std::string folder;       ///< DIR
    int repeats = 3;          ///< processes a rung, for its times
    std::string layer = "E";  ///< that is compared
    std::string hard_cases;   ///< folder of timelines; empty: none
    std::string claims;       ///< a claim's file or a folder of them, without a timeline; empty: none
    int threads = 0;
    std::string device;
    std::string command_line;  ///< for the report
};

/// Renders a timeline by every method over its ladder, each rung by processes of its own of this program, and
/// judges them by the reference; or the runs of claims, each by its own reference; then the hard cases.
/// Writes bench.csv, bench.json and index.html into the folder and prints a table.
///
///     DIR/references/JOB/     the reference's frames by job hash, used again by every bench of the same job
///     DIR/runs/RUNG/          the last repeat's frames; timings.json: what all repeats cost
///     DIR/claims/CLAIM/RUN/
///     DIR/hard_cases/CASE/METHOD/
///
/// May be ended at any moment: the same call goes on, and trusts what is there only where the job's hash is
/// the same. A repeat that was broken off is begun again, so that its times are those of one process.
///
/// Returns done, interrupted, or check_failed where a run failed, a hard case does not hold, or a row
/// of a claim has no figure or one beyond what is expected. Throws
/// Error(usage), TimelineError, Error(output_unwritable), and what the reference's run failed with.
ExitCode bench(const BenchOptions& options, const run::Interruption& interruption, run::Reporter& reporter);

}  // namespace dapple::judge
