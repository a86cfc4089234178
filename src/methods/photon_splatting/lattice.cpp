#include "methods/photon_splatting/lattice.h"

namespace dapple::methods {
namespace {

// Euclid's algorithm on floats: quotients beyond this many steps are below round-off.
constexpr int kMostSteps = 40;
// A basis gets a share where the least term (see below) is more than this part of its own.
constexpr float kSharedFrom = 0.4f;

/// Lagrange's and Gauss's reduction: first is a shortest vector, second a shortest one beside it.
void shorten(Vectors2& first, Vectors2& second, const Metric& metric) {
    Flags going = all(true);
    for (int step = 0; step < kMostSteps && lanes::any(going); ++step) {
        const Floats first_square = metric.product(first, first),
                     second_square = metric.product(second, second);
        const Flags swap = going & (second_square < first_square);
        const Vectors2 shorter = choose(swap, second, first);
        second = choose(swap, first, second);
        first = shorter;
        const Floats short_square = lanes::lesser(first_square, second_square);
        const Floats whole = lanes::rounded(metric.product(first, second) / short_square);
        // A nearly collapsed lattice: the remainder would be round-off only.
        going &= (short_square > 0.0f) & (whole != 0.0f) & (lanes::magnitude(whole) <= 1e6f);
        second = choose(going, second - whole * first, second);
    }
}

/// Exchanges two bases where the first has no weight.
void sink_weightless(LatticeBasis& first, LatticeBasis& second) {
    const Flags empty = first.weight == 0.0f;
    const LatticeBasis sunk = first;
    first = {choose(empty, second.first, sunk.first), choose(empty, second.second, sunk.second),
             empty ? second.weight : sunk.weight};
    second = {choose(empty, sunk.first, second.first), choose(empty, sunk.second, second.second),
              empty ? sunk.weight : second.weight};
}

}  // namespace

ReducedLattice reduce_lattice(Vectors2 first, Vectors2 second, const Metric& metric) {
    shorten(first, second, metric);
    second = choose(metric.product(first, second) > 0.0f, -second, second);
    // Selling's obtuse superbase: three vectors that sum to zero, no two at less than a right angle. Each two
    // are a basis; the term of a pair is 0 where it is rectangular, and there, where the superbase changes,
    // the other two pairs must have no share.
    const std::array<Vectors2, 3> v = {-(first + second), first, second};
    std::array<Floats, 3> term;
    for (std::size_t k = 0; k < 3; ++k)
        term[k] = lanes::greater(Floats{}, -metric.product(v[(k + 1) % 3], v[(k + 2) % 3]));
    const Floats least = lanes::lesser(lanes::lesser(term[0], term[1]), term[2]);
    ReducedLattice lattice;
    Floats sum{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Floats ratio = term[k] > least ? least / term[k] : all(1.0f);
        const Floats x = (ratio - kSharedFrom) * (1 / (1 - kSharedFrom));
        // Rectangular or collapsed: the one pair has all.
        const Flags taken = (least == 0.0f) & (sum > 0.0f);
        const Floats weight = (x > 0.0f) & ~taken ? x * x * (3.0f - 2.0f * x) : Floats{};
        lattice[k] = {v[(k + 1) % 3], v[(k + 2) % 3], weight};
        sum += weight;
    }
    const Floats inverse = 1.0f / sum;
    for (LatticeBasis& basis : lattice) basis.weight *= inverse;
    sink_weightless(lattice[0], lattice[1]);
    sink_weightless(lattice[1], lattice[2]);
    sink_weightless(lattice[0], lattice[1]);
    return lattice;
}

}  // namespace dapple::methods
