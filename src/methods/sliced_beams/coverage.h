#pragma once
#include <limits>

#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// Landed beams, a lane each, in footprint coordinates: the receiver's footprint is the unit square about 0.
template <class Real>
struct LandedBeams {
    Lanes<Real> x[3], y[3];
};

template <class Real>
inline Lanes<Real> to_square(Lanes<Real> x) {
    constexpr Real half = Real(0.5);
    return lesser(greater(x, splat<Real>(-half)), splat<Real>(half));
}

/// Area between the square's line y = `base` and an edge from (x0, y0) to (x1, y1), both held within the
/// square: the integral over x of (y held within the square) - base; negative where the edge runs to the
/// left. The two beams of a shared edge get the same number but for its sign, whatever its direction, and
/// `base`.
template <class Real>
inline Lanes<Real> area_below_edge(Lanes<Real> x0, Lanes<Real> y0, Lanes<Real> x1, Lanes<Real> y1,
                                   Lanes<Real> base) {
    using L = Lanes<Real>;
    const auto swapped = x0 > x1;
    const L left_x = swapped ? x1 : x0, right_x = swapped ? x0 : x1;
    const L left_y = swapped ? y1 : y0, right_y = swapped ? y0 : y1;
    const L run = right_x - left_x;
    const L slope = run > 0 ? (right_y - left_y) / run : L{};
    const L from_x = to_square<Real>(left_x), to_x = to_square<Real>(right_x);
    const L from = left_y + (from_x - left_x) * slope;
    const L to = right_y + (to_x - right_x) * slope;
    // Mean of the held height over [from, to]: the integral of a function of three straight pieces.
    const L half = splat<Real>(Real(0.5));
    const L held_from = to_square<Real>(from), held_to = to_square<Real>(to);
    const L above = greater(to, half) - greater(from, half);
    const L below = lesser(to, -half) - lesser(from, -half);
    const L rise = to - from;
    const L integral = half * ((held_to - held_from) * (held_to + held_from) + (above - below));
    const L mean = rise == 0 ? held_from : integral / rise;
    const L area = (to_x - from_x) * (mean - base);
    return swapped ? -area : area;
}

/// Twice the signed area of the whole triangles.
template <class Real>
inline Lanes<Real> doubled_area(const LandedBeams<Real>& b) {
    return (b.x[1] - b.x[0]) * (b.y[2] - b.y[0]) - (b.x[2] - b.x[0]) * (b.y[1] - b.y[0]);
}

/// Share of the longest edge that lies within the square: what a beam that is landed on a line covers.
template <class Real>
inline Lanes<Real> covered_share_of_longest_edge(const LandedBeams<Real>& b) {
    using L = Lanes<Real>;
    L longest = splat<Real>(-1), x{}, y{}, dx{}, dy{};
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        const L ex = b.x[next] - b.x[k], ey = b.y[next] - b.y[k];
        const L squared = ex * ex + ey * ey;
        const auto longer = squared > longest;
        longest = longer ? squared : longest;
        x = longer ? b.x[k] : x;
        y = longer ? b.y[k] : y;
        dx = longer ? ex : dx;
        dy = longer ? ey : dy;
    }
    const L zero{}, one = splat<Real>(1), half = splat<Real>(Real(0.5));
    L enter = zero, leave = one;
    const auto clip = [&](L start, L delta) {
        const auto moving = delta != 0;
        const L safe = moving ? delta : one;
        const L t0 = (-half - start) / safe, t1 = (half - start) / safe;
        const auto inside = magnitude(start) <= half;
        enter = moving ? greater(enter, lesser(t0, t1)) : (inside ? enter : one);
        leave = moving ? lesser(leave, greater(t0, t1)) : (inside ? leave : zero);
    };
    clip(x, dx);
    clip(y, dy);
    const L share = greater(zero, leave - enter);
    // A beam landed in one point is inside or outside.
    const auto point_inside = (magnitude(x) <= half) & (magnitude(y) <= half);
    return longest > 0 ? share : (point_inside ? one : zero);
}

/// Lanes whose bounding box meets the square.
template <class Real>
inline Mask<Real> may_meet_square(const LandedBeams<Real>& b) {
    const Lanes<Real> half = splat<Real>(Real(0.5));
    const auto low_x = lesser(lesser(b.x[0], b.x[1]), b.x[2]),
               high_x = greater(greater(b.x[0], b.x[1]), b.x[2]);
    const auto low_y = lesser(lesser(b.y[0], b.y[1]), b.y[2]),
               high_y = greater(greater(b.y[0], b.y[1]), b.y[2]);
    return (low_x <= half) & (high_x >= -half) & (low_y <= half) & (high_y >= -half);
}

/// Share of each landed beam's area that lies within the footprint, in [0, 1]. A beam so thin that its area
/// is lost in the rounding of its corners counts by the length of its longest edge.
template <class Real>
inline Lanes<Real> covered_share(const LandedBeams<Real>& b) {
    using L = Lanes<Real>;
    const L zero{}, one = splat<Real>(1);
    const L base = to_square<Real>(b.y[0]);
    L area = zero;
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        area += area_below_edge<Real>(b.x[k], b.y[k], b.x[next], b.y[next], base);
    }
    const L whole = Real(0.5) * doubled_area(b);
    const L low_x = lesser(lesser(b.x[0], b.x[1]), b.x[2]), high_x = greater(greater(b.x[0], b.x[1]), b.x[2]);
    const L low_y = lesser(lesser(b.y[0], b.y[1]), b.y[2]), high_y = greater(greater(b.y[0], b.y[1]), b.y[2]);
    // Corners are rounded by about epsilon times their distance from the receiver, which is at most the size
    // of a beam that meets the square, and half; at 256 times the area which that is worth, the line is right
    // to a 256th of the beam's width. By the size alone, so that all receivers of a tiling take a beam for
    // the same: else its shares would not sum to 1.
    constexpr Real rounding = Real(256) * std::numeric_limits<Real>::epsilon();
    const L half = splat<Real>(Real(0.5));
    const L size = greater(high_x - low_x, high_y - low_y);
    const auto thin = magnitude(whole) <= rounding * (size + half) * size;
    L share = magnitude(area) / (thin ? one : magnitude(whole));
    if (any(thin)) share = thin ? covered_share_of_longest_edge(b) : share;
    const auto inside = (low_x >= -half) & (high_x <= half) & (low_y >= -half) & (high_y <= half);
    share = inside ? one : lesser(share, one);
    return share > zero ? share : zero;  // also where a corner is not finite
}

}  // namespace dapple::methods::sliced_beams
