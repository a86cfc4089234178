#pragma once
#include <map>
#include <string>
#include <vector>

#include "judge/bench_errors.h"
#include "scene/frame_state.h"

namespace dapple::judge {

enum class Verdict {
    holds,  ///< whole, finite, and its light is the reference's
    named,  ///< the same where it answers; the plan or the stats say what it leaves out
    fails,
};

std::string to_string(Verdict verdict);

/// Light that a method may lose or gain against the reference: 1 %, beside three standard errors of the sum.
inline constexpr double kEnergyTolerance = 0.01;

/// How the light that media scatter (S) did in a hard case.
struct ScatteredVerdict {
    Verdict verdict = Verdict::fails;
    std::string reason;  ///< one line, with its numbers
    double energy = 0;   ///< S over the picture less the reference's, a share
    double l1 = 0;       ///< relative, over all pixels
};

/// What is known of S beside the pictures.
struct ScatteredEvidence {
    /// Standard error of the reference's sum over the picture, a share of it.
    double reference_error = 0;
    std::map<std::string, double> counts = {};  ///< of the run's stats, summed up over frames
    std::string plan = {};                      ///< what it says of light that is left out; empty: nothing
    /// The pixels that the plan does not leave out.
    ErrorJudge::Pixels answered = {};
};

/// Of a frame the pixels that show media by straight ways only, by neither water, mirrors nor glass, as all
/// their neighbors do.
std::vector<bool> seen_straight(const scene::FrameState& state);

/// A run that has the layer S. Holds where the light of the picture is the reference's within
/// kEnergyTolerance and three standard errors. Light that is missing is named where what the method loses by
/// its own fault ("lost ..., W" of "light on specular surfaces, W") is as large a share; or where the plan
/// says that some pixels are left out and the others hold, by their variance and by how much larger the
/// error of the reference's whole sum is than that of independent pixels.
ScatteredVerdict judge_scattered(const ErrorJudge& judge, const run::OutputPaths& run,
                                 const ScatteredEvidence& evidence);

/// Light that counts name as lost and that a reference would not lose, W: all of "lost ..., W" but for what
/// is absorbed, sent into another chain, leaves the scene, or falls on another wave.
double lost_by_method(const std::map<std::string, double>& counts);

}  // namespace dapple::judge
