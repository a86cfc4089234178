#pragma once
#include <optional>
#include <string>
#include <vector>

#include "judge/bench_errors.h"
#include "judge/bench_runs.h"
#include "judge/bench_scattered.h"

namespace dapple::judge {

/// How a method did in a hard case.
struct CaseVerdict {
    std::string method;
    Verdict verdict = Verdict::fails;  ///< of the process, of values that are not finite, and of E
    std::string reason;                ///< one line, with its number
    int exit_code = 0;
    std::size_t non_finite = 0;  ///< values
    double energy = 0;           ///< light of E over the picture less the reference's, a share
    double l1 = 0;               ///< relative, over pixels that both cover
    double lost = 0;             ///< W that the stats name as lost on the way
    double wall_s = 0;           ///< of the process
    /// Where the timeline has media that scatter.
    std::optional<ScatteredVerdict> scattered = {};
};

struct HardCase {
    std::string name;         ///< of the file
    std::string description;  ///< the comment in its first line
    std::string reference;    ///< what the reference did: its noise, or why it did not
    std::vector<CaseVerdict> verdicts;
};

/// Renders one case by the reference (to 5 %, or 30 million rays a light) and each method into
/// FOLDER/METHOD, and judges them; a timeline that names a method may set its keys, all others have their
/// defaults. Fewer verdicts where it is interrupted.
HardCase judge_hard_case(const std::string& timeline, const std::vector<std::string>& methods,
                         const std::string& folder, Renderings& renderings);

/// Light of E that a method may lose or gain against the reference: kEnergyTolerance, beside three standard
/// errors of the sum over the pixels that are covered, or over a `share` of these.
double energy_tolerance(const ReferenceNoise& noise, double share = 1);

/// Light of E that a method lacks or has too much where it is compared, as a share of the reference's there,
/// or of the mean of its whole picture where that is brighter: shares of next to nothing tell nothing, and
/// the reference's own pixels run into each other at edges.
double energy_where_compared(const ClipErrors& errors, const ReferenceNoise& noise);

}  // namespace dapple::judge
