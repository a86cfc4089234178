#pragma once

/// On which side of landed edges a point lies, decided exactly, so that of the triangles about an edge one
/// alone holds it.
namespace dapple::methods::sliced_beams {

/// A landing point relative to the receiver, rounded so that products are exact in double.
struct Landed {
    float x = 0, y = 0;
};

/// Sign of the area of the triangle (0, p, q), exact; the point 0 counts as moved by an infinitely small step
/// along (1, e), so that no edge contains it (Edelsbrunner & Muecke 1990). 0 where p = q.
inline int side(const Landed& p, const Landed& q) {
    const double left = static_cast<double>(p.x) * static_cast<double>(q.y);
    const double right = static_cast<double>(q.x) * static_cast<double>(p.y);
    if (left != right) return left > right ? 1 : -1;
    if (p.y != q.y) return p.y > q.y ? 1 : -1;
    if (p.x != q.x) return q.x > p.x ? 1 : -1;
    return 0;
}

/// Sign of the orientation of a triangle whose corners are given relative to a point, without regard to it.
inline int orientation(const Landed& a, const Landed& b, const Landed& c) {
    const double area = (static_cast<double>(b.x) - static_cast<double>(a.x)) *
                            (static_cast<double>(c.y) - static_cast<double>(a.y)) -
                        (static_cast<double>(c.x) - static_cast<double>(a.x)) *
                            (static_cast<double>(b.y) - static_cast<double>(a.y));
    return area > 0 ? 1 : area < 0 ? -1 : 0;
}

/// 1 or -1 where the triangle holds the point, 0 elsewhere.
inline int holds(const Landed& a, const Landed& b, const Landed& c) {
    const int first = side(a, b);
    return first != 0 && first == side(b, c) && first == side(c, a) ? first : 0;
}

}  // namespace dapple::methods::sliced_beams
