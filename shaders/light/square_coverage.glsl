// How much of the unit square a triangle covers, and where: by Green's theorem sums over its edges of integrals over
// the part of the square that lies left of the edge. `precise`, so that a layer has the same bits in any batch.

// Signed integrals of 1, x and y over the part of the square (x, y in [0, 1]) left of the edge, positive where the
// edge leads to larger y. The same bits for both directions of an edge, but for the sign, so that neighbours fit.
vec3 edge_moments(vec2 from, vec2 to) {
    bool up = from.y <= to.y;
    precise vec2 low = up ? from : to;
    precise vec2 high = up ? to : from;
    precise float rise = high.y - low.y;
    precise float y_0 = clamp(low.y, 0.0, 1.0);
    precise float y_1 = clamp(high.y, 0.0, 1.0);
    if (!(y_1 > y_0)) return vec3(0.0);
    precise float run = high.x - low.x;
    precise float x_0 = low.x + (y_0 - low.y) / rise * run;
    precise float x_1 = low.x + (y_1 - low.y) / rise * run;
    // Between `begin` and `end`, shares of the way from y_0 to y_1, the edge lies in the square.
    precise float across = x_1 - x_0;
    precise float at_0 = across != 0.0 ? clamp(-x_0 / across, 0.0, 1.0) : 0.0;
    precise float at_1 = across != 0.0 ? clamp((1.0 - x_0) / across, 0.0, 1.0) : 0.0;
    precise float begin = y_0 + min(at_0, at_1) * (y_1 - y_0);
    precise float end = y_0 + max(at_0, at_1) * (y_1 - y_0);
    precise float c_0 = clamp(x_0, 0.0, 1.0);
    precise float c_1 = clamp(x_1, 0.0, 1.0);
    precise float before = begin - y_0, within = end - begin, after = y_1 - end;
    precise vec3 moments;
    moments.x = c_0 * before + 0.5 * (c_0 + c_1) * within + c_1 * after;
    moments.y = 0.5 * (c_0 * c_0 * before + c_1 * c_1 * after) + (c_0 * c_0 + c_0 * c_1 + c_1 * c_1) * within / 6.0;
    moments.z = 0.5 * (c_0 * before * (y_0 + begin) + c_1 * after * (end + y_1)) +
                within * (begin * (2.0 * c_0 + c_1) + end * (c_0 + 2.0 * c_1)) / 6.0;
    return up ? moments : -moments;
}

// Triangles smaller than this, in squares, count as a whole: a gradient across them would have no digits.
const float kSmallestArea = 1e-3;

// Integrals over the part of the triangle in the square of its three barycentric coordinates. `moments`: the sum of
// those of its edges.
vec3 barycentric_integrals(vec2 a, vec2 b, vec2 c, vec3 moments) {
    precise vec2 ab = b - a, ac = c - a;
    precise float twice = ab.x * ac.y - ab.y * ac.x;
    if (twice < 0.0) moments = -moments;
    precise vec3 shares = vec3(moments.x / 3.0);
    if (abs(twice) > kSmallestArea) {
        precise vec2 about = moments.yz - moments.x * (a + (ab + ac) / 3.0);
        shares.y += (about.x * ac.y - about.y * ac.x) / twice;
        shares.z += (ab.x * about.y - ab.y * about.x) / twice;
        shares.x = moments.x - shares.y - shares.z;
    }
    return shares;
}
