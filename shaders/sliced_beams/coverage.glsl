// Coverage of one footprint by one landed beam: the arithmetic of src/methods/sliced_beams/coverage.h, beam by beam.
// All of it is precise, so that no compiler fuses or reorders what must round as it does there.

float to_square(float x) { return min(max(x, -0.5), 0.5); }

// Integral over an edge's part above the square of (its height held within the square) - base.
float area_below_edge(float x0, float y0, float x1, float y1, float base) {
    bool swapped = x0 > x1;
    precise float left_x = swapped ? x1 : x0, right_x = swapped ? x0 : x1;
    precise float left_y = swapped ? y1 : y0, right_y = swapped ? y0 : y1;
    precise float run = right_x - left_x;
    precise float slope = run > 0.0 ? (right_y - left_y) / run : 0.0;
    precise float from_x = to_square(left_x), to_x = to_square(right_x);
    precise float from = left_y + (from_x - left_x) * slope;
    precise float to = right_y + (to_x - right_x) * slope;
    precise float held_from = to_square(from), held_to = to_square(to);
    precise float above = max(to, 0.5) - max(from, 0.5);
    precise float below = min(to, -0.5) - min(from, -0.5);
    precise float rise = to - from;
    precise float integral = 0.5 * ((held_to - held_from) * (held_to + held_from) + (above - below));
    precise float mean = rise == 0.0 ? held_from : integral / rise;
    precise float area = (to_x - from_x) * (mean - base);
    return swapped ? -area : area;
}

// The part [range.x, range.y] of a way that lies within the square along one axis.
void clip_way(float start, float delta, inout vec2 range) {
    bool moving = delta != 0.0;
    float safe = moving ? delta : 1.0;
    precise float t0 = (-0.5 - start) / safe, t1 = (0.5 - start) / safe;
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
    precise float size = max(high.x - low.x, high.y - low.y);
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

// Share of a landed beam's area within the footprint, in [0, 1]. Beams so thin that they count by their longest edge
// are left out, and said to be there: few are, and devices that run both sides of a branch should not pay for each.
float covered_share(vec3 x, vec3 y, inout bool thin_beams) {
    vec2 low = vec2(min(min(x.x, x.y), x.z), min(min(y.x, y.y), y.z));
    vec2 high = vec2(max(max(x.x, x.y), x.z), max(max(y.x, y.y), y.z));
    if (!meets_square(low, high)) return 0.0;
    float whole = whole_area(x, y);
    if (is_thin(whole, low, high)) {
        thin_beams = true;
        return 0.0;
    }
    float base = to_square(y.x);
    precise float area = area_below_edge(x.x, y.x, x.y, y.y, base);
    area += area_below_edge(x.y, y.y, x.z, y.z, base);
    area += area_below_edge(x.z, y.z, x.x, y.x, base);
    return lies_within_square(low, high) ? 1.0 : min(abs(area) / whole, 1.0);
}

// The same for those beams alone.
float covered_share_if_thin(vec3 x, vec3 y) {
    vec2 low = vec2(min(min(x.x, x.y), x.z), min(min(y.x, y.y), y.z));
    vec2 high = vec2(max(max(x.x, x.y), x.z), max(max(y.x, y.y), y.z));
    if (!meets_square(low, high) || !is_thin(whole_area(x, y), low, high)) return 0.0;
    return lies_within_square(low, high) ? 1.0 : min(covered_share_of_longest_edge(x, y), 1.0);
}
