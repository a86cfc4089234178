#include "methods/photon_splatting/lattice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dapple::methods {
namespace {

// Euclid's algorithm on floats: quotients beyond this many steps are below round-off.
constexpr int kMostSteps = 40;
// Skew (the share of the first vector in the second, at most 1/2 when reduced) above which two bases share
// the flux.
constexpr float kSharedSkew = 0.4f;

float product(glm::vec2 a, glm::vec2 b, const glm::mat2& metric) {
    return glm::dot(a, metric * b);
}

}  // namespace

ReducedLattice reduce_lattice(glm::vec2 first, glm::vec2 second, const glm::mat2& metric) {
    float skew = 0;
    for (int step = 0; step < kMostSteps; ++step) {
        float short_square = product(first, first, metric);
        const float long_square = product(second, second, metric);
        if (long_square < short_square) {
            std::swap(first, second);
            short_square = long_square;
        }
        skew = 0;
        if (!(short_square > 0)) break;
        skew = product(first, second, metric) / short_square;
        const float whole = std::round(skew);
        // A nearly collapsed lattice: the remainder would be round-off only.
        if (whole == 0 || std::abs(whole) > 1e6f) break;
        second -= whole * first;
        skew -= whole;
    }
    ReducedLattice lattice;
    lattice.bases[0] = {first, second, 1};
    const float over = (std::min(std::abs(skew), 0.5f) - kSharedSkew) / (1 - 2 * kSharedSkew);
    if (over <= 0) return lattice;
    // From 0 at the threshold to 1/2 at the tie, where the other basis takes over with the same shares.
    const float share = over * over * (3 - 2 * over);
    lattice.count = 2;
    lattice.bases[0].weight = 1 - share;
    lattice.bases[1] = {first, second - std::copysign(1.0f, skew) * first, share};
    return lattice;
}

}  // namespace dapple::methods
