// Coverage of one footprint by one landed beam: the arithmetic of src/methods/sliced_beams/coverage.h, beam by beam.
// All of it is precise, so that no compiler fuses or reorders what must round as it does there.
#include "sliced_beams/quotient.glsl"

// By comparison, as one or two instructions: what min and max owe to NaN costs more on some devices.
float lesser(float x, float y) { return x < y ? x : y; }
float greater(float x, float y) { return x > y ? x : y; }
float least_of(vec3 v) { return lesser(lesser(v.x, v.y), v.z); }
float greatest_of(vec3 v) { return greater(greater(v.x, v.y), v.z); }
float to_square(float x) { return lesser(greater(x, -0.5), 0.5); }

// Integral over an edge's part above the square of (its height held within the square) - base. No end comes first in
// it: with the ends changed over each difference changes its sign and nothing else, so that the two beams of an edge
// get the same number but for its sign.
float area_below_edge(float x0, float y0, float x1, float y1, float base) {
    precise float run = x1 - x0;
    precise float slope = run == 0.0 ? 0.0 : quotient(y1 - y0, run);
    precise float from_x = to_square(x0), to_x = to_square(x1);
    precise float from = y0 + (from_x - x0) * slope;
    precise float to = y1 + (to_x - x1) * slope;
    precise float held_from = to_square(from), held_to = to_square(to);
    precise float above = greater(to, 0.5) - greater(from, 0.5);
    precise float below = lesser(to, -0.5) - lesser(from, -0.5);
    precise float rise = to - from;
    precise float integral = 0.5 * ((held_to - held_from) * (held_to + held_from) + (above - below));
    precise float mean = rise == 0.0 ? held_from : quotient(integral, rise);
    precise float area = (to_x - from_x) * (mean - base);
    return area;
}

// The part [range.x, range.y] of a way that lies within the square along one axis.
void clip_way(float start, float delta, inout vec2 range) {
    bool moving = delta != 0.0;
    float safe = moving ? delta : 1.0;
    precise float t0 = quotient(-0.5 - start, safe), t1 = quotient(0.5 - start, safe);
    bool inside = abs(start) <= 0.5;
    range.x = moving ? max(range.x, min(t0, t1)) : (inside ? range.x : 1.0);
    range.y = moving ? min(range.y, max(t0, t1)) : (inside ? range.y : 0.0);
}

// What a beam that is landed on a line covers.
float covered_share_of_longest_edge(vec3 x, vec3 y) {
    float longest = -1.0, from_x = 0.0, from_y = 0.0, way_x = 0.0, way_y = 0.0;
    for (int k = 0; k < 3; ++k) {
        int next = (k + 1) % 3;
        precise float ex = x[next] - x[k], ey = y[next] - y[k];
        precise float squared = ex * ex + ey * ey;
        bool longer = squared > longest;
        longest = longer ? squared : longest;
        from_x = longer ? x[k] : from_x;
        from_y = longer ? y[k] : from_y;
        way_x = longer ? ex : way_x;
        way_y = longer ? ey : way_y;
    }
    vec2 range = vec2(0.0, 1.0);
    clip_way(from_x, way_x, range);
    clip_way(from_y, way_y, range);
    bool point_inside = abs(from_x) <= 0.5 && abs(from_y) <= 0.5;
    return longest > 0.0 ? max(0.0, range.y - range.x) : (point_inside ? 1.0 : 0.0);
}

// Whether a beam's box meets the square, and whether its area is lost in the rounding of its corners.
bool meets_square(vec2 low, vec2 high) {
    return low.x <= 0.5 && high.x >= -0.5 && low.y <= 0.5 && high.y >= -0.5;
}
bool is_thin(float whole, vec2 low, vec2 high) {
    const float rounding = 256.0 / 8388608.0;  // 256 times the spacing of floats at 1
    precise float size = greater(high.x - low.x, high.y - low.y);
    precise float least = rounding * (size + 0.5) * size;
    return whole <= least;
}
bool lies_within_square(vec2 low, vec2 high) {
    return low.x >= -0.5 && high.x <= 0.5 && low.y >= -0.5 && high.y <= 0.5;
}
float whole_area(vec3 x, vec3 y) {
    precise float doubled = (x.y - x.x) * (y.z - y.x) - (x.z - x.x) * (y.y - y.x);
    return abs(0.5 * doubled);
}

// Share of a landed beam's area within the footprint, in [0, 1]; a beam too thin for that counts by its longest edge.
float covered_share(vec3 x, vec3 y) {
    vec2 low = vec2(least_of(x), least_of(y)), high = vec2(greatest_of(x), greatest_of(y));
    float share = 0.0;
    if (meets_square(low, high)) {
        float whole = whole_area(x, y);
        if (is_thin(whole, low, high)) {
            share = covered_share_of_longest_edge(x, y);
        } else {
            float base = to_square(y.x);
            precise float area = area_below_edge(x.x, y.x, x.y, y.y, base);
            area += area_below_edge(x.y, y.y, x.z, y.z, base);
            area += area_below_edge(x.z, y.z, x.x, y.x, base);
            share = quotient(abs(area), whole);
        }
        share = lies_within_square(low, high) ? 1.0 : lesser(share, 1.0);
    }
    return share;
}
