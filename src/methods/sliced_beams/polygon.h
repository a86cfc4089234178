#pragma once
#include <array>
#include <cmath>
#include <cstddef>

#include "methods/sliced_beams/coverage.h"

namespace dapple::methods::sliced_beams {

/// The part of one landed beam that lies in the light (past_start >= 0) and within the footprint's unit
/// square.
template <class Real>
struct ClippedBeam {
    Real share = 0;               ///< of the beam's landed area
    Real weights[3] = {0, 0, 0};  ///< barycentric coordinates of the part's centre
};

/// By cutting the triangle with one line after the other (Sutherland & Hodgman 1974), corners in barycentric
/// coordinates. A beam landed on a line is shared by its corners' mean.
template <class Real>
ClippedBeam<Real> clip_beam(const Real (&x)[3], const Real (&y)[3], const Real (&past_start)[3]) {
    using Corner = std::array<Real, 3>;
    // A convex polygon gains one corner a cut; one that rounding has bent, at most half as many again.
    std::array<Corner, 24> polygon{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, cut;
    std::size_t corners = 3;
    const auto value = [](const Corner& c, const Real(&f)[3]) {
        return c[0] * f[0] + c[1] * f[1] + c[2] * f[2];
    };
    const auto keep = [&](const Real(&f)[3], Real sign, Real offset) {  // where sign * f + offset >= 0
        std::size_t kept = 0;
        for (std::size_t i = 0; i < corners; ++i) {
            const Corner& from = polygon[i];
            const Corner& to = polygon[(i + 1) % corners];
            const Real f0 = sign * value(from, f) + offset, f1 = sign * value(to, f) + offset;
            if (f0 >= 0) cut[kept++] = from;
            if ((f0 >= 0) != (f1 >= 0)) {
                const Real t = f0 / (f0 - f1);
                for (std::size_t k = 0; k < 3; ++k) cut[kept][k] = from[k] + t * (to[k] - from[k]);
                ++kept;
            }
        }
        polygon = cut;
        corners = kept;
    };
    keep(past_start, 1, 0);
    for (const Real sign : {Real(1), Real(-1)}) {
        if (corners > 0) keep(x, sign, Real(0.5));
        if (corners > 0) keep(y, sign, Real(0.5));
    }
    ClippedBeam<Real> result;
    if (corners == 0) return result;
    // Area in barycentric coordinates: the whole beam is 1/2.
    Real area = 0, first = 0, second = 0;
    for (std::size_t i = 1; i + 1 < corners; ++i) {
        const Corner &p = polygon[0], &q = polygon[i], &r = polygon[i + 1];
        const Real part = (q[1] - p[1]) * (r[2] - p[2]) - (r[1] - p[1]) * (q[2] - p[2]);
        area += part;
        first += part * (p[1] + q[1] + r[1]) / 3;
        second += part * (p[2] + q[2] + r[2]) / 3;
    }
    result.share = std::abs(area);
    if (result.share > Real(1e-6)) {
        result.weights[1] = first / area;
        result.weights[2] = second / area;
    } else {
        for (std::size_t i = 0; i < corners; ++i) {
            result.weights[1] += polygon[i][1] / static_cast<Real>(corners);
            result.weights[2] += polygon[i][2] / static_cast<Real>(corners);
        }
    }
    result.weights[0] = 1 - result.weights[1] - result.weights[2];
    return result;
}

}  // namespace dapple::methods::sliced_beams
