#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/frame_state.h"

namespace dapple::reference {

/// Passes of a round.
constexpr std::uint64_t kPasses = 16;

/// How fast errors of a stratified pass fall: with the strata to the power of minus 1 / exponent.
constexpr double kIrradianceExponent = 1.5, kInScatterExponent = 2;

/// Passes of equal size, whose means are independent estimates of one layer, and what they say so far.
/// Rounds follow one another: the first is small, and one that does not reach the standard error that is
/// asked for is thrown away for another of more strata. (In a stratified pass errors fall faster than by the
/// root of the number of rays, so few large passes beat many small ones.)
struct RoundEstimate {
    std::uint64_t strata = 0;           ///< a pass and light
    std::uint64_t passes = 0;           ///< done in this round
    std::uint64_t rays = 0;             ///< a light, of all rounds
    bool done = false;                  ///< the last round is complete
    bool extinguished = false;          ///< of S: media dimmed light to 0 at places of this round
    std::vector<glm::dvec3> mean;       ///< of each value, over the passes
    std::vector<glm::dvec3> deviation;  ///< sum of squared deviations from it (Welford 1962)

    /// Empties it for a round of that size.
    void start(std::uint64_t strata_a_pass, std::size_t values);
    void add_pass(const std::vector<glm::dvec3>& values);
    /// Squared standard error of the mean, of one value; passes >= 2.
    glm::dvec3 variance(std::size_t value) const;
    /// Of the values from `first` on: mean standard error over mean (means of the channels). Where all are 0,
    /// 0 if that is the truth, and 1 if light may have been missed (`extinguished`).
    double relative_error(std::size_t first) const;
    /// After a whole round: ends the estimate or starts the next round. `rays_a_pass` are those of a light.
    void end_round(std::size_t first, std::uint64_t rays_a_pass, double exponent,
                   const scene::ReferenceParameters& parameters);
};

}  // namespace dapple::reference
