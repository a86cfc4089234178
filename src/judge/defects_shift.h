#pragma once
#include <optional>

#include "metrics/picture.h"

namespace dapple::judge {

/// A picture that stands beside its reference: I(x + dx, y + dy) = R(x, y), in pixels to the right and down.
struct Shift {
    double dx = 0, dy = 0;
};

/// The translation within kMostShift pixels to either side that leaves the smallest mean square of v_I - v_R
/// (v as in JumpFinder, of `level`), over every fourth pixel of every fourth row; refined by parabolas
/// through the neighbours. Nothing where the pictures fit best as they are, or no other place makes the mean
/// square smaller than kGain times what it is.
inline constexpr int kMostShift = 8;
inline constexpr double kGain = 0.7;
std::optional<Shift> find_shift(const metrics::Picture& picture, const metrics::Picture& reference,
                                double level);

}  // namespace dapple::judge
