// The cross-section of a beam, of which beam_fragment.glsl takes intervals and light: signs of its edges, areas and
// densities of its corners' rings. Needs its varyings and the buffer `turning`.

const float kTiny = 1.17549435e-38;
const float kRounding = 1.19209290e-7;

// Products are rounded by themselves: only so does swapping the corners change nothing but the sign.
float cross_2(vec2 p, vec2 q) {
    precise float pq = p.x * q.y;
    precise float qp = q.x * p.y;
    precise float result = pq - qp;
    return result;
}

// The sign of an edge on whose line a point lies: as if the point were moved by an infinitely small step along
// (1, e), so that one of the edge's two beams holds it (Edelsbrunner & Muecke 1990).
float tie(vec2 edge) { return edge.y < 0.0 || (edge.y == 0.0 && edge.x > 0.0) ? kTiny : -kTiny; }

float side(vec2 p, vec2 q) {
    float w = cross_2(p, q);
    return w == 0.0 ? tie(q - p) : w;
}

bool one_sign(vec3 w) { return all(greaterThan(w, vec3(0.0))) || all(lessThan(w, vec3(0.0))); }

float at(vec3 q, float t) { return q.x + t * (q.y + t * q.z); }

// m^2: |A| at three depths.
vec3 area_at(vec4 area, vec3 depth) {
    vec3 u = depth - area.w;
    return abs(area.x + u * (area.y + u * area.z));
}

// m^2: that rounding of its corners' places gives a ring.
vec3 least_areas(float depth) {
    vec4 way = abs(vec4(1.0, 1.0, depth, depth));
    vec3 size = vec3(dot(abs(ray_0), way), dot(abs(ray_1), way), dot(abs(ray_2), way));
    vec3 rounding = kRounding * max(size, vec3(1e-3));
    return rounding * rounding;
}

// m^2: of the corners' rings at three depths; never 0.
void ring_areas(vec3 depth, out vec3 a0, out vec3 a1, out vec3 a2) {
    vec3 first = area_at(area_0, depth), second = area_at(area_1, depth), third = area_at(area_2, depth);
#ifdef LISTED
    for (uint i = uint(listed_ends_on.x); i < uint(listed_ends_on.y); ++i) {
        TurningArea one = turning[i];
        vec3 of_corner = vec3(one.corners & 1u, one.corners >> 1 & 1u, one.corners >> 2 & 1u);
        vec3 area = area_at(one.area, depth);
        first += area * of_corner.x;
        second += area * of_corner.y;
        third += area * of_corner.z;
    }
#endif
    vec3 least = least_areas(depth.y);
    a0 = max(vec3(first.x, second.x, third.x), least);
    a1 = max(vec3(first.y, second.y, third.y), least);
    a2 = max(vec3(first.z, second.z, third.z), least);
}

vec3 ends() { return end_bias.xyz; }

float start_bias() { return flux_start_bias.w; }

vec3 starts() { return vec3(flux_start_0.w, flux_start_1.w, flux_start_2.w); }

vec3 barycentric(vec3 w) {
    float sum = w.x + w.y + w.z;
    return sum == 0.0 ? vec3(1.0 / 3.0) : w / sum;
}

// W/m^2 through the plane of constant depth.
vec3 density(vec3 share, vec3 area) {
    vec3 part = share / area;
    return part.x * flux_start_0.xyz + part.y * flux_start_1.xyz + part.z * flux_start_2.xyz;
}

// m a m of depth: along the light at a point.
vec3 along_light(vec3 share) { return vec3(share.x * ray_0.zw + share.y * ray_1.zw + share.z * ray_2.zw, 1.0); }
