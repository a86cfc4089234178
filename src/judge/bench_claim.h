#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "judge/bench_errors.h"

/// Claims of papers, held to figures: files that people write, a claim each.
namespace dapple::judge {

/// What a row of a claim measures of a run.
struct Figure {
    std::string_view name;
    std::string_view meaning;
    enum class Kind {
        error,   ///< of the run's pictures against others: `error`
        count,   ///< of a name in the stats, summed over the frames
        cpu,     ///< CPU seconds a frame, of all passes or of those that are named
        wall,    ///< the same by the clock
        memory,  ///< bytes, peak of the process
    };
    Kind kind = Kind::error;
    double (*error)(const ClipErrors& errors) = nullptr;
    /// What the noise of a reference is by this figure, where it is one that noise adds to in squares.
    std::optional<double> ReferenceNoise::*noise = nullptr;

    /// Whether it is the same on every machine and in every repeat.
    bool repeats() const { return kind == Kind::error || kind == Kind::count; }
};

/// All of them, in the order in which messages name them.
const std::vector<Figure>& claim_figures();

/// Of a picture: what lies at these depths (layer Z of the first sample, m) and in this box, whose ends are
/// shares of the picture's width and height (left, top, right, bottom).
struct ClaimRegion {
    std::string name;
    double nearest = 0;
    double farthest = std::numeric_limits<double>::infinity();
    std::array<double, 4> box{0, 0, 1, 1};
};

struct ClaimRun {
    std::string name;
    std::vector<std::string> overrides;  ///< of the timeline, as for --set
};

/// Name of the run that errors are against where nothing is said, and whose own error is its noise.
inline constexpr const char* kClaimReference = "reference";

/// "RUN" or "RUN against RUN".
struct ClaimTerm {
    std::string run;
    std::string against = kClaimReference;
};

/// One figure, or its ratio to others.
struct ClaimRow {
    std::string says;
    const Figure* figure = nullptr;
    std::string region;               ///< empty: the whole picture
    std::string count;                ///< name in the stats
    std::vector<std::string> passes;  ///< of cpu and wall; empty: all but writing
    ClaimTerm of;
    /// What it is divided by: several are the root of the sum of their squares, as errors that have nothing
    /// to do with each other add; none: 1.
    std::vector<ClaimTerm> over;
    std::optional<double> at_least, at_most;            ///< what the source claims of it
    std::optional<std::pair<double, double>> expected;  ///< what is found here, where that repeats
    std::string because;                                ///< why these
};

struct Claim {
    std::string file, name;     ///< its path, and its stem
    std::string source, claim;  ///< where it stands, and in words
    std::string timeline;       ///< path
    std::string layer = "E";    ///< that errors are of
    std::vector<std::int64_t> frames;
    std::optional<ClaimRun> reference;
    std::vector<ClaimRun> runs;
    std::vector<ClaimRegion> regions;
    std::vector<ClaimRow> rows;
};

/// Reads a claim. Throws TimelineError with all faults of the file, Error(input_unreadable).
Claim read_claim(const std::string& path);

/// A file, or the files (*.yaml) of a folder, sorted. Throws Error(usage) where there is none.
std::vector<std::string> claim_files(const std::string& path);

}  // namespace dapple::judge
