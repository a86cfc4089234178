// One beam against a part of a camera segment: what src/methods/sliced_beams/beam_slices.h does for eight segments.
// Along the part, t in [-1, 1], twice the areas beside the beam's edges are quadratics c.x + c.y t + c.z t^2.

// The place of a ray about the segment's point: at + t moves.
struct Place {
    vec2 at, moves;
};

float value(vec3 c, float t) {
    precise float v = (c.z * t + c.y) * t + c.x;
    return v;
}

// Twice the area between the origin, a moving place, and the place that a moving step leads to from there. By the step,
// as the product of two places loses the digits of the small areas of beams about a focus.
vec3 beside(Place p, Place to) {
    precise float c0 = fma(p.at.x, to.at.y, -(p.at.y * to.at.x));
    precise float half_c1 = fma(p.at.x, to.moves.y, -(p.at.y * to.moves.x));
    precise float c1 = fma(p.moves.x, to.at.y, fma(-p.moves.y, to.at.x, half_c1));
    precise float c2 = fma(p.moves.x, to.moves.y, -(p.moves.y * to.moves.x));
    return vec3(c0, c1, c2);
}

// Beside the edge from p to q, in exactly this order. A segment in the edge's own plane counts as moved by an
// infinitely small step along (1, e), so that one of the edge's two beams holds it (Edelsbrunner & Muecke 1990).
vec3 beside_edge(Place p, Place q) {
    precise vec2 at = q.at - p.at, moves = q.moves - p.moves;
    vec3 c = beside(p, Place(at, moves));
    if (c == vec3(0.0)) {
        precise vec2 along = at + moves;
        c.x = along.y < 0.0 || (along.y == 0.0 && along.x > 0.0) ? 1e-37 : -1e-37;
    }
    return c;
}

// Where the area changes its sign in [from, to], at whose ends it has different ones and between which it is monotone.
float crossing(vec3 c, float from, float to) {
    precise float discriminant = max(c.y * c.y - 4.0 * c.x * c.z, 0.0);
    float root = sqrt(discriminant);
    precise float sum = c.y + (c.y < 0.0 ? -root : root);
    // The smaller root, and, should that one lie outside, the other; 4: far outside.
    float at = abs(c.x) < 2.0 * abs(sum) ? -2.0 * c.x / sum : 4.0;
    if (abs(sum) < 4.0 * abs(c.z)) {
        float other = -0.5 * sum / c.z, middle = 0.5 * (from + to);
        at = abs(other - middle) < abs(at - middle) ? other : at;
    }
    return clamp(at, from, to);
}

// Where the area turns around within (-1, 1) and is zero twice; 1: nowhere. Cut there, it is zero once on each side.
float turning_place(vec3 c) {
    bool inside = abs(c.y) < 2.0 * abs(c.z);
    precise float discriminant = c.y * c.y - 4.0 * c.x * c.z;
    return inside && discriminant >= 0.0 ? clamp(-0.5 * c.y / c.z, -1.0, 1.0) : 1.0;
}

// Parts of [from, to], two at most and ascending, in which a cubic is positive: .xy and .zw, empty where the first end
// is not less than the second.
float cubic(vec4 c, float t) { return c.x + t * (c.y + t * (c.z + t * c.w)); }
vec4 positive_parts(vec4 c, float from, float to) {
    // Monotone between the places where its slope is 0.
    float low_turn = to, high_turn = to;
    float discriminant = c.z * c.z - 3.0 * c.w * c.y;
    if (discriminant > 0.0) {
        float q = -(c.z + (c.z < 0.0 ? -sqrt(discriminant) : sqrt(discriminant)));
        float turn = abs(q) < 12.0 * abs(c.w) ? q / (3.0 * c.w) : to;
        float other = abs(c.y) < 4.0 * abs(q) ? c.y / q : to;
        turn = turn > from && turn < to ? turn : to;
        other = other > from && other < to ? other : to;
        low_turn = min(turn, other);
        high_turn = max(turn, other);
    }
    vec4 parts = vec4(to);
    float low = from;
    for (int i = 0; i < 3; ++i) {
        float high = i == 0 ? low_turn : (i == 1 ? high_turn : to);
        bool starts = cubic(c, low) > 0.0, stops = cubic(c, high) > 0.0;
        float inside = starts ? low : high, outside = starts ? high : low;
        for (int step = 0; starts != stops && step < 32; ++step) {
            float middle = 0.5 * (inside + outside);
            bool holds = cubic(c, middle) > 0.0;
            inside = holds ? middle : inside;
            outside = holds ? outside : middle;
        }
        vec2 part = vec2(starts ? low : inside, stops ? high : inside);
        if ((starts || stops) && part.x < part.y) {
            if (!(parts.x < parts.y))
                parts.xy = part;
            else if (parts.y == part.x)
                parts.y = part.y;
            else if (!(parts.z < parts.w) || parts.w != part.x)
                parts.zw = part;
            else
                parts.w = part.y;
        }
        low = high;
    }
    return parts;
}
