// Light of pieces of a segment within a beam: what src/methods/sliced_beams/scatter_piece.cpp and
// segment_quadrature.cpp do. Works on the segment and the beam that scatter.comp has taken.

// The ray through a point of the beam.
struct Node {
    float path;          // m from the water to the point, and back to the segment's near end
    float stretch;       // m of way a m of depth
    float squared_sine;  // of half the angle between the ways before and after
};
Node node_at(float t) {
    float w0 = edge_area(0, t), w1 = edge_area(1, t), w2 = edge_area(2, t);
    float whole = w0 + w1 + w2;
    bool flat_there = whole == 0.0;
    float l1 = flat_there ? 1.0 / 3.0 : w1 / (flat_there ? 1.0 : whole);
    float l2 = flat_there ? 1.0 / 3.0 : w2 / (flat_there ? 1.0 : whole);
    vec2 slope = l1 * (pass[1].zw - pass[0].zw) + (l2 * (pass[2].zw - pass[0].zw) + pass[0].zw);
    float begins = l1 * (starts[1] - starts[0]) + (l2 * (starts[2] - starts[0]) + starts[0]);
    float depth = t * part_moves.z + part_at.z;
    Node n;
    n.stretch = sqrt(dot(slope, slope) + 1.0);
    n.path = (depth - begins) * n.stretch + (t * part_half + part_middle);
    // |before - after| / 2: half the angle between unit vectors loses no digits so.
    vec3 turn = vec3(slope, 1.0) / n.stretch + direction;
    n.squared_sine = 0.25 * dot(turn, turn);
    return n;
}

float phase(float squared_sine) {
    if (push.cells > 0) {
        float place = float(push.cells) * sqrt(sqrt(clamp(squared_sine, 0.0, 1.0)));
        uint cell = min(uint(place), push.cells);
        float low = phases[cell], high = phases[cell + 1];
        return low + (place - float(cell)) * (high - low);
    }
    float p = push.even;
    for (int i = 0; i < 2; ++i) {
        float root = inversesqrt(push.lobes[i].z * squared_sine + push.lobes[i].y);
        p += push.lobes[i].x * root * (root * root);
    }
    return p;
}

float inverse_area(float doubled) { return abs(doubled) > kLeastArea ? 1.0 / abs(doubled) : 0.0; }

// Whether c.x + c.y u + c.z u^2 is 0 in [-1, 1].
bool has_root(vec3 c) {
    if (!(c.x - c.y + c.z > 0.0) || !(c.x + c.y + c.z > 0.0) || !(c.x > 0.0)) return true;
    float discriminant = c.y * c.y - 4.0 * c.x * c.z;
    float q = 0.5 * (abs(c.y) + sqrt(max(discriminant, 0.0)));
    return discriminant >= 0.0 && c.x <= q;
}

// Weights for which sum_j weight[j] g(node j) is the integral of g(u) / (c.x + c.y u + c.z u^2) over [-1, 1] for g of
// degree two, like product_weights(): from the integrals of Lagrange's polynomials over the area, itself by three nodes
// on parts that are so short that it changes little along each; by 5e-7 at most this is off.
vec3 product_weights(vec3 c) {
    vec3 weight = vec3(0.0);
    float from = -1.0;
    for (int part = 0; part < 256 && from < 1.0; ++part) {
        float at = max(value(c, from), kLeastArea), rises = abs(c.y + 2.0 * c.z * from), bends = abs(c.z);
        float reach = 1.0 - from;
        // 0.3 of the area, by its slope and by its bend.
        reach = rises * reach > 0.3 * at ? 0.3 * at / rises : reach;
        reach = bends * reach * reach > 0.06 * at ? sqrt(0.06 * at / bends) : reach;
        float to = max(from + reach, from + 1e-7);
        to = to < 1.0 ? to : 1.0;
        float middle = 0.5 * (from + to), half_length = 0.5 * (to - from);
        for (int k = -1; k < 2; ++k) {
            float u = middle + float(k) * kNode * half_length;
            float density = (k == 0 ? 8.0 / 9.0 : 5.0 / 9.0) * half_length * inverse_area(value(c, u));
            weight += density * vec3(u * (u - kNode) / 1.2, 1.0 - u * u / 0.6, u * (u + kNode) / 1.2);
        }
        from = to;
        ++work;
    }
    return weight;
}


// Twice the beam's area along [enter, leave], as a polynomial on [-1, 1], made positive in the middle.
vec3 area_of(float enter, float leave) {
    float middle = 0.5 * (enter + leave), half_length = 0.5 * (leave - enter);
    vec3 c = vec3(value(area, middle), half_length * (2.0 * area.z * middle + area.y),
                  half_length * half_length * area.z);
    return c.x < 0.0 ? -c : c;
}
// Whether three nodes do for the integral of one over it.
bool is_even(vec3 c) { return abs(c.y) + 3.0 * abs(c.z) <= kEvenEnough * c.x; }
// The rule's weights over it; 0 where it is lost in rounding.
vec3 even_weights(vec3 c) {
    float even = 0.6 * c.z + c.x;
    return vec3(5.0, 8.0, 5.0) / 9.0 *
           vec3(inverse_area(even - kNode * c.y), inverse_area(c.x), inverse_area(even + kNode * c.y));
}

// Whether the edges' areas sum to the beam's at a point of a piece, within half of it. Near a focus, where they are
// lost in rounding, their signs may be the same by chance where the segment is not in the beam at all.
bool is_sound(float t) {
    float whole = edge_area(0, t) + edge_area(1, t) + edge_area(2, t), exact = value(area, t);
    return abs(whole - exact) <= 0.5 * abs(exact);
}

// Light of a piece by three nodes; `change` becomes its change of optical depth, in the densest channel.
vec3 light_of(vec3 weight, float enter, float leave, out float change) {
    float middle = 0.5 * (enter + leave), reach = 0.5 * kNode * (leave - enter);
    Node n0 = node_at(middle - reach), n1 = node_at(middle), n2 = node_at(middle + reach);
    vec3 most = push.extinction;
    change = abs(n2.path - n0.path) / kNode * max(max(most.x, most.y), most.z);
    weight *= 0.5 * (leave - enter) * part_half;
    weight *= vec3(n0.stretch * phase(n0.squared_sine), n1.stretch * phase(n1.squared_sine),
                   n2.stretch * phase(n2.squared_sine));
    vec3 path = max(vec3(n0.path, n1.path, n2.path), vec3(0.0));
    vec3 light;
    for (int c = 0; c < 3; ++c) {
        vec3 depth = push.extinction[c] * path;
        light[c] = dot(weight, vec3(decay(depth.x), decay(depth.y), decay(depth.z)));
    }
    return push.scattered * beams[taken].flux * light;
}

// Adds the light of a piece that lies within the beam, in the water and before all that may stop it, and that is
// neither thick nor narrows much; false where it is no such piece.
bool add_plain(float enter, float leave) {
    float first = enter * part_moves.z + part_at.z, last = leave * part_moves.z + part_at.z;
    bool plain = min(first, last) >= beams[taken].last_start && max(first, last) <= beams[taken].first_stop;
    vec3 c = area_of(enter, leave);
    vec3 weight = even_weights(c);
    float change;
    vec3 light = light_of(weight, enter, leave, change);
    plain = plain && is_sound(0.5 * (enter + leave)) && is_even(c) && change <= kThinEnough &&
            min(min(weight.x, weight.y), weight.z) > 0.0;
    if (plain) {
        sum.radiance += light;
        ++sum.intervals;
    }
    return plain;
}

// The same of any piece that is free, along which optical depth changes little.
void add_thin(float enter, float leave) {
    vec3 c = area_of(enter, leave);
    vec3 weight = even_weights(c);
    if (!is_even(c)) {
        ++sum.peaks;
        if (has_root(c))
            ++sum.foci;
        else
            weight = product_weights(c);
    }
    if (weight.x == 0.0 || weight.y == 0.0 || weight.z == 0.0) sum.dropped += 3;
    float change;
    sum.radiance += light_of(weight, enter, leave, change);
}

// The same of any piece that is free: cut where nothing of the light is left, and into parts of little optical depth.
void add_free(float enter, float leave) {
    float most = max(max(push.extinction.x, push.extinction.y), push.extinction.z);
    float least = min(min(push.extinction.x, push.extinction.y), push.extinction.z);
    float first = node_at(enter).path, last = node_at(leave).path;
    float way = abs(last - first);
    uint parts = enter < leave ? 1 : 0;
    if (way * most > kThinEnough) {
        float share = 1.0;
        if (least > 0.0) share = clamp((kOpaque / least - max(min(first, last), 0.0)) / way, 0.0, 1.0);
        float reach = share * (leave - enter);
        if (first <= last)
            leave = enter + reach;
        else
            enter = leave - reach;
        parts *= uint(clamp(ceil(share * way * most / kThinEnough), 1.0, kMostParts));
    }
    float from = enter;
    for (uint i = 1; i <= parts; ++i) {
        float to = enter + (leave - enter) * (float(i) / float(parts));
        add_thin(from, to);
        from = to;
        ++work;
    }
}

// Coefficients of the cubic that has the sign of the area where a point lies beyond (sign 1), or before (-1), depths
// that are linear over the beam's slices: the edges' areas times the distances from the corners' depths.
vec4 beyond(float depth[3], float sign, float middle) {
    float held = edge_area(0, middle) < 0.0 ? -sign : sign;
    vec4 c = vec4(0.0);
    for (int k = 0; k < 3; ++k) {
        vec3 w = turned[k] ? -edge[k] : edge[k];
        float at = held * (part_at.z - depth[k]), moves = held * part_moves.z;
        c += vec4(w * at, 0.0) + vec4(0.0, w * moves);
    }
    return c;
}

// The same of any piece: of it what lies in the water, and before an object stops the beam.
void add_piece(float enter, float leave, float stops[3]) {
    float first = enter * part_moves.z + part_at.z, last = leave * part_moves.z + part_at.z;
    bool dry = min(first, last) < beams[taken].last_start, stopped = max(first, last) > beams[taken].first_stop;
    if (dry || stopped) ++sum.cut;
    float middle = 0.5 * (enter + leave);
    if (!is_sound(middle)) {
        ++sum.foci;
        return;
    }
    vec4 wet = vec4(enter, leave, leave, leave);
    if (dry) wet = positive_parts(beyond(starts, 1.0, middle), enter, leave);
    vec4 before = beyond(stops, -1.0, middle);
    for (int i = 0; i < 2; ++i) {
        vec2 below = i == 0 ? wet.xy : wet.zw;
        vec4 lit = vec4(below, below.yy);
        if (stopped) lit = positive_parts(before, below.x, below.y);
        for (int j = 0; j < 2; ++j) {
            vec2 part = j == 0 ? lit.xy : lit.zw;
            if (part.x < part.y) {
                ++sum.intervals;
                add_free(part.x, part.y);
            }
        }
    }
}
