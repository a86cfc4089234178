#include "methods/photon_splatting/lattice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dapple::methods {
namespace {

// Euclid's algorithm on floats: quotients beyond this many steps are below round-off.
constexpr int kMostSteps = 40;
// A basis gets a share where the least term (see below) is more than this part of its own.
constexpr float kSharedFrom = 0.4f;

float product(glm::vec2 a, glm::vec2 b, const glm::mat2& metric) {
    return glm::dot(a, metric * b);
}

/// Lagrange's and Gauss's reduction: first is a shortest vector, second a shortest one beside it.
void shorten(glm::vec2& first, glm::vec2& second, const glm::mat2& metric) {
    for (int step = 0; step < kMostSteps; ++step) {
        float short_square = product(first, first, metric);
        const float long_square = product(second, second, metric);
        if (long_square < short_square) {
            std::swap(first, second);
            short_square = long_square;
        }
        if (!(short_square > 0)) return;
        const float whole = std::round(product(first, second, metric) / short_square);
        // A nearly collapsed lattice: the remainder would be round-off only.
        if (whole == 0 || std::abs(whole) > 1e6f) return;
        second -= whole * first;
    }
}

}  // namespace

ReducedLattice reduce_lattice(glm::vec2 first, glm::vec2 second, const glm::mat2& metric) {
    shorten(first, second, metric);
    if (product(first, second, metric) > 0) second = -second;
    // Selling's obtuse superbase: three vectors that sum to zero, no two at less than a right angle. Each two
    // are a basis; the term of a pair is 0 where it is rectangular, and there, where the superbase changes,
    // the other two pairs must have no share.
    const std::array<glm::vec2, 3> v = {-(first + second), first, second};
    std::array<float, 3> term{};
    for (std::size_t k = 0; k < 3; ++k)
        term[k] = std::max(0.0f, -product(v[(k + 1) % 3], v[(k + 2) % 3], metric));
    const float least = std::min({term[0], term[1], term[2]});
    ReducedLattice lattice;
    lattice.count = 0;
    float sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const float ratio = term[k] > least ? least / term[k] : 1.0f;
        const float x = (ratio - kSharedFrom) / (1 - kSharedFrom);
        if (!(x > 0)) continue;
        LatticeBasis& basis = lattice.bases[static_cast<std::size_t>(lattice.count++)];
        basis = {v[(k + 1) % 3], v[(k + 2) % 3], x * x * (3 - 2 * x)};
        sum += basis.weight;
        if (least == 0) break;  // rectangular or collapsed: the one pair has all
    }
    for (LatticeBasis& basis : lattice.bases) basis.weight /= sum;
    return lattice;
}

}  // namespace dapple::methods
