#pragma once
#include <limits>

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

/// Beams that share an edge get the same numbers for it but for the sign, so that a segment leaves the one
/// where it enters the other.
template <class Real>
inline BeamSlices<Real> slices(const BeamCorner<Real> (&corner)[3], const SegmentParts<Real>& part) {
    using L = Lanes<Real>;
    L x0[3], y0[3], x1[3], y1[3];
    for (int k = 0; k < 3; ++k) {
        const L slope_a = splat(corner[k].slope_a), slope_b = splat(corner[k].slope_b);
        x0[k] = multiply_add(part.depth, slope_a, corner[k].a - part.a);
        y0[k] = multiply_add(part.depth, slope_b, corner[k].b - part.b);
        x1[k] = multiply_add(part.half_depth, slope_a, -part.half_a);
        y1[k] = multiply_add(part.half_depth, slope_b, -part.half_b);
    }
    // Products are rounded by themselves: only so does swapping the corners change nothing but the sign.
    const auto cross = [](L x, L y, L u, L v) { return x * v - u * y; };
    BeamSlices<Real> result;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        result.edge[k] = {cross(x0[i], y0[i], x0[j], y0[j]),
                          cross(x1[i], y1[i], x0[j], y0[j]) + cross(x0[i], y0[i], x1[j], y1[j]),
                          cross(x1[i], y1[i], x1[j], y1[j])};
        // A segment in an edge's own plane counts as moved by an infinitely small step along (1, e), so that
        // one of the edge's two beams holds it (Edelsbrunner & Muecke 1990).
        Quadratic<Real>& edge = result.edge[k];
        const auto along = (edge.c0 == 0) & (edge.c1 == 0) & (edge.c2 == 0);
        if (any(along)) {
            constexpr Real tiny = std::numeric_limits<Real>::min();
            const L rise = y0[j] - y0[i] + (y1[j] - y1[i]), run = x0[j] - x0[i] + (x1[j] - x1[i]);
            const auto positive = (rise < 0) | ((rise == 0) & (run > 0));
            edge.c0 = along ? (positive ? splat(tiny) : splat(-tiny)) : edge.c0;
        }
    }
    // Not as the edges' sum, which loses digits where the point is far from the beam.
    L ex0[2], ey0[2], ex1[2], ey1[2];
    for (int k = 0; k < 2; ++k) {
        const L slope_a = splat(corner[k + 1].slope_a - corner[0].slope_a);
        const L slope_b = splat(corner[k + 1].slope_b - corner[0].slope_b);
        ex0[k] = multiply_add(part.depth, slope_a, splat(corner[k + 1].a - corner[0].a));
        ey0[k] = multiply_add(part.depth, slope_b, splat(corner[k + 1].b - corner[0].b));
        ex1[k] = part.half_depth * slope_a;
        ey1[k] = part.half_depth * slope_b;
    }
    result.area = {cross(ex0[0], ey0[0], ex0[1], ey0[1]),
                   cross(ex1[0], ey1[0], ex0[1], ey0[1]) + cross(ex0[0], ey0[0], ex1[1], ey1[1]),
                   cross(ex1[0], ey1[0], ex1[1], ey1[1])};
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
