#pragma once
#include "base/lane_vectors.h"

/// shaders/light/square_coverage.glsl for eight pixels at once, the same sums in the same order.
namespace dapple::methods::caustic_mesh {

inline lanes::Floats clamped(lanes::Floats x, lanes::Floats low, lanes::Floats high) {
    return lanes::lesser(lanes::greater(x, low), high);
}

/// Signed integrals of 1, x and y over the part of the unit square left of the edge, positive where the edge
/// leads to larger y.
inline lanes::Vectors3 edge_moments(lanes::Vectors2 from, lanes::Vectors2 to) {
    using lanes::Floats;
    const Floats none = lanes::all(0.0f), one = lanes::all(1.0f);
    const lanes::Flags up = from.y <= to.y;
    const lanes::Vectors2 low = choose(up, from, to), high = choose(up, to, from);
    const Floats rise = high.y - low.y;
    const Floats y_0 = clamped(low.y, none, one), y_1 = clamped(high.y, none, one);
    const lanes::Flags met = y_1 > y_0;
    if (!lanes::any(met)) return {};
    const Floats run = high.x - low.x;
    const Floats x_0 = low.x + (y_0 - low.y) / rise * run;
    const Floats x_1 = low.x + (y_1 - low.y) / rise * run;
    // Between `begin` and `end`, shares of the way from y_0 to y_1, the edge lies in the square.
    const Floats across = x_1 - x_0;
    const Floats at_0 = across != 0.0f ? clamped(-x_0 / across, none, one) : none;
    const Floats at_1 = across != 0.0f ? clamped((1.0f - x_0) / across, none, one) : none;
    const Floats begin = y_0 + lanes::lesser(at_0, at_1) * (y_1 - y_0);
    const Floats end = y_0 + lanes::greater(at_0, at_1) * (y_1 - y_0);
    const Floats c_0 = clamped(x_0, none, one), c_1 = clamped(x_1, none, one);
    const Floats before = begin - y_0, within = end - begin, after = y_1 - end;
    const lanes::Vectors3 moments{
        c_0 * before + 0.5f * (c_0 + c_1) * within + c_1 * after,
        0.5f * (c_0 * c_0 * before + c_1 * c_1 * after) + (c_0 * c_0 + c_0 * c_1 + c_1 * c_1) * within / 6.0f,
        0.5f * (c_0 * before * (y_0 + begin) + c_1 * after * (end + y_1)) +
            within * (begin * (2.0f * c_0 + c_1) + end * (c_0 + 2.0f * c_1)) / 6.0f};
    return lanes::choose(met, choose(up, moments, -moments), {});
}

/// Triangles smaller than this, in squares, count as a whole: a gradient across them would have no digits.
constexpr float kSmallestArea = 1e-3f;

/// Integrals over the part of the triangle in the square of its three barycentric coordinates. `moments`: the
/// sum of those of its edges.
inline lanes::Vectors3 barycentric_integrals(lanes::Vectors2 a, lanes::Vectors2 b, lanes::Vectors2 c,
                                             lanes::Vectors3 moments) {
    using lanes::Floats;
    const lanes::Vectors2 ab = b - a, ac = c - a;
    const Floats twice = cross(ab, ac);
    moments = choose(twice < 0.0f, -moments, moments);
    const Floats third = moments.x / 3.0f;
    const lanes::Vectors2 about{moments.y - moments.x * (a.x + (ab.x + ac.x) / 3.0f),
                                moments.z - moments.x * (a.y + (ab.y + ac.y) / 3.0f)};
    const Floats of_b = third + cross(about, ac) / twice, of_c = third + cross(ab, about) / twice;
    return lanes::choose(lanes::magnitude(twice) > kSmallestArea, {moments.x - of_b - of_c, of_b, of_c},
                         {third, third, third});
}

}  // namespace dapple::methods::caustic_mesh
