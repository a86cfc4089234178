#pragma once
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "methods/sliced_beams/landing.h"
#include "methods/sliced_beams/lanes.h"

/// One beam against parts of camera segments, a segment a lane. At any depth a beam is the triangle of its
/// three rays; along a segment depth, and so the rays' places about the segment's point, are linear, and
/// twice the areas of the triangles between that point and the beam's edges are quadratics: the segment is in
/// the beam where all three have one sign.
namespace dapple::methods::sliced_beams {

/// c0 + c1 t + c2 t^2.
template <class Real>
struct Quadratic {
    Lanes<Real> c0, c1, c2;
    Lanes<Real> operator()(Lanes<Real> t) const { return multiply_add(multiply_add(c2, t, c1), t, c0); }
};

/// Parts of segments in a sheet's axes, m: middle + t half, t in [-1, 1].
template <class Real>
struct SegmentParts {
    Lanes<Real> a, b, depth;
    Lanes<Real> half_a, half_b, half_depth;
};

template <class Real>
struct BeamCorner {
    Real a, b, slope_a, slope_b, start;
};

template <class Real>
struct BeamSlices {
    Quadratic<Real> edge[3];  ///< m^2, twice the signed area beside the edge that faces a corner
    Quadratic<Real> area;     ///< their sum, twice the beam's area
};

/// The place of a corner's ray about the segment's point, as a function of t: (x0 + x1 t, y0 + y1 t).
template <class Real>
inline void place(const BeamCorner<Real>& corner, const SegmentParts<Real>& part, Lanes<Real>& x0,
                  Lanes<Real>& y0, Lanes<Real>& x1, Lanes<Real>& y1) {
    const Lanes<Real> slope_a = splat(corner.slope_a), slope_b = splat(corner.slope_b);
    x0 = multiply_add(part.depth, slope_a, corner.a - part.a);
    y0 = multiply_add(part.depth, slope_b, corner.b - part.b);
    x1 = multiply_add(part.half_depth, slope_a, -part.half_a);
    y1 = multiply_add(part.half_depth, slope_b, -part.half_b);
}

/// Twice the area of the triangle between the origin, a moving place (x, y) and the place that a moving step
/// leads to from there, which is given turned by a quarter: (v, minus_u). By the step, as a product of two
/// places loses the digits of the small areas about a focus, where beams are narrow beside their distance
/// from the segment's middle, and the edges of a beam no longer agree on where it is.
template <class L>
inline auto beside(const L& x0, const L& y0, const L& x1, const L& y1, const L& minus_u0, const L& v0,
                   const L& minus_u1, const L& v1) {
    using Real = std::remove_cvref_t<decltype(x0[0])>;
    const L first = multiply_add(x0, v1, y0 * minus_u1);
    return Quadratic<Real>{multiply_add(x0, v0, y0 * minus_u0),
                           multiply_add(x1, v0, multiply_add(y1, minus_u0, first)),
                           multiply_add(x1, v1, y1 * minus_u1)};
}

/// The same over [-1, 1] for the part about `middle` of half its size.
template <class Real>
inline Quadratic<Real> part_of(const Quadratic<Real>& whole, const Lanes<Real>& middle,
                               const Lanes<Real>& half) {
    return {whole(middle), half * multiply_add(Real(2) * whole.c2, middle, whole.c1), half * half * whole.c2};
}

/// A segment in an edge's own plane counts as moved by an infinitely small step along (1, e), so that one of
/// the edge's two beams holds it (Edelsbrunner & Muecke 1990): c0 for it. `run`, `rise`: the edge at t = 1.
template <class Real>
inline Lanes<Real> off_edge(const Quadratic<Real>& edge, const Lanes<Real>& run, const Lanes<Real>& rise) {
    constexpr Real tiny = std::numeric_limits<Real>::min();
    const auto along = (edge.c0 == 0) & (edge.c1 == 0) & (edge.c2 == 0);
    const auto positive = (rise < 0) | ((rise == 0) & (run > 0));
    return along ? (positive ? splat(tiny) : splat(-tiny)) : edge.c0;
}

/// Twice the area of a beam along the segments. Not as the edges' sum, which loses digits where the point is
/// far from the beam.
template <class Real>
inline Quadratic<Real> beam_area(const BeamCorner<Real>& corner, const BeamCorner<Real>& second,
                                 const BeamCorner<Real>& third, const SegmentParts<Real>& part) {
    using L = Lanes<Real>;
    L x0[2], y0[2], x1[2], y1[2];
    const BeamCorner<Real>* const others[2] = {&second, &third};
    for (int k = 0; k < 2; ++k) {
        const L slope_a = splat(others[k]->slope_a - corner.slope_a);
        const L slope_b = splat(others[k]->slope_b - corner.slope_b);
        x0[k] = multiply_add(part.depth, slope_a, splat(others[k]->a - corner.a));
        y0[k] = multiply_add(part.depth, slope_b, splat(others[k]->b - corner.b));
        x1[k] = part.half_depth * slope_a;
        y1[k] = part.half_depth * slope_b;
    }
    return beside(x0[0], y0[0], x1[0], y1[0], -x0[1], y0[1], -x1[1], y1[1]);
}

/// Which way an edge runs, for both of its beams alike: only so do they get the same numbers for it.
template <class Real>
inline bool in_order(const BeamCorner<Real>& from, const BeamCorner<Real>& to) {
    return std::tie(from.a, from.b, from.slope_a, from.slope_b) <=
           std::tie(to.a, to.b, to.slope_a, to.slope_b);
}

/// Beams that share an edge get the same numbers for it but for the sign, so that a segment leaves the one
/// where it enters the other.
template <class Real>
inline BeamSlices<Real> slices(const BeamCorner<Real> (&corner)[3], const SegmentParts<Real>& part) {
    Lanes<Real> x0[3], y0[3], x1[3], y1[3];
    for (int k = 0; k < 3; ++k) place(corner[k], part, x0[k], y0[k], x1[k], y1[k]);
    BeamSlices<Real> result;
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        const bool turned = !in_order(corner[i], corner[j]);
        if (turned) std::swap(i, j);
        Quadratic<Real>& edge = result.edge[k];
        edge = beside(x0[i], y0[i], x1[i], y1[i], x0[i] - x0[j], y0[j] - y0[i], x1[i] - x1[j], y1[j] - y1[i]);
        if (any(edge.c0 == 0))
            edge.c0 = off_edge<Real>(edge, x0[j] - x0[i] + (x1[j] - x1[i]), y0[j] - y0[i] + (y1[j] - y1[i]));
        if (turned) edge = {-edge.c0, -edge.c1, -edge.c2};
    }
    result.area = beam_area(corner[0], corner[1], corner[2], part);
    return result;
}

/// Calls `visit(enter, leave, mask)` for the pieces of [-1, 1] that lie in the beam, each lane's first ones
/// first: once for most beams.
template <class Real, class Visit>
inline void visit_pieces(const BeamSlices<Real>& beam, Mask<Real> wanted, Visit&& visit) {
    using L = Lanes<Real>;
    const L one = splat(Real(1));
    // Most edges have one sign all along.
    L bound[3];
    Mask<Real> above[3], below[3];
    for (int k = 0; k < 3; ++k) {
        bound[k] = magnitude(beam.edge[k].c1) + magnitude(beam.edge[k].c2);
        above[k] = beam.edge[k].c0 > bound[k];
        below[k] = beam.edge[k].c0 < -bound[k];
    }
    wanted &= ~((above[0] | above[1] | above[2]) & (below[0] | below[1] | below[2]));
    if (!any(wanted)) return;

    // Places where an edge is crossed; 1 where there are fewer.
    L cut[6];
    int cuts = 0;
    L second[3];
    int seconds = 0;
    for (int k = 0; k < 3; ++k) {
        if (!any(wanted & ~(above[k] | below[k]))) continue;
        const auto& [c0, c1, c2] = beam.edge[k];
        const L discriminant = c1 * c1 - Real(4) * c0 * c2;
        const auto real = discriminant >= 0;
        const L root = square_root<Real>(real ? discriminant : L{});
        const L q = Real(-0.5) * (c1 + (c1 < 0 ? -root : root));
        const L r1 = q / c2, r2 = c0 / q;
        const auto in1 = real & (magnitude(r1) < one), in2 = real & (magnitude(r2) < one);
        cut[cuts++] = in2 ? r2 : (in1 ? r1 : one);
        if (any(wanted & in1 & in2)) second[seconds++] = (in1 & in2) ? r1 : one;
    }
    for (int k = 0; k < seconds; ++k) cut[cuts++] = second[k];
    for (int i = 1; i < cuts; ++i) {  // ascending
        for (int j = i; j > 0; --j) {
            const L low = lesser(cut[j - 1], cut[j]);
            cut[j] = greater(cut[j - 1], cut[j]);
            cut[j - 1] = low;
        }
    }
    L from[7], to[7];
    Mask<Real> inside[7];
    for (int i = 0; i <= cuts; ++i) {
        from[i] = i == 0 ? -one : cut[i - 1];
        to[i] = i == cuts ? one : cut[i];
        const L middle = Real(0.5) * (from[i] + to[i]);
        const L w0 = beam.edge[0](middle), w1 = beam.edge[1](middle), w2 = beam.edge[2](middle);
        inside[i] = wanted & (from[i] < to[i]) &
                    (((w0 > 0) & (w1 > 0) & (w2 > 0)) | ((w0 < 0) & (w1 < 0) & (w2 < 0)));
    }
    for (;;) {
        L enter = -one, leave = one;
        Mask<Real> found{};
        for (int i = 0; i <= cuts; ++i) {
            const Mask<Real> first = inside[i] & ~found;
            enter = first ? from[i] : enter;
            leave = first ? to[i] : leave;
            found |= first;
            inside[i] &= ~first;
        }
        if (!any(found)) return;
        visit(enter, leave, found);
    }
}

}  // namespace dapple::methods::sliced_beams
