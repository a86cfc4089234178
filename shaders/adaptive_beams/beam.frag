#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// What one beam sends through one pixel: S, scattered once on the part of the camera's segment that lies in the
// beam, and E, at the receiver. On every plane of constant depth a beam is the triangle of its three rays; along a
// camera ray depth is linear, and so twice the areas of the triangles between the ray's point and the beam's edges
// are quadratics: the point is in the beam where all three have one sign, and they are its barycentric coordinates.
// The density of flux is that of the corners, interpolated: a corner's is the flux of its ring of triangles over their
// area (after Ernst et al. 2005), so that it is continuous across beams, and the sum over all triangles of area times
// mean density is the sum of their flux.
#define WAY in
#include "adaptive_beams/beam_varyings.glsl"
#include "layout/beam_volume.h"

layout(scalar, binding = 2) readonly buffer Turning { TurningArea turning[]; };
layout(scalar, binding = 4) readonly buffer Frames { BeamFrame frame; };
// Length of the primary segment [m], way to the receiver [m], 0: none; whether they are in the water.
layout(binding = 5) uniform sampler2D pixels;
layout(binding = 6) uniform sampler2D normals;  // of receivers, world space
layout(scalar, push_constant) uniform Push { BeamPush push; };
layout(location = 0) out vec4 scattered;   // W/m^2/sr; and 1, which counts fragments
layout(location = 1) out vec4 irradiance;  // W/m^2
#include "adaptive_beams/phase.glsl"

const float kTiny = 1.17549435e-38;

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

// m^2: of the ring of a corner at a depth.
float ring_area(vec3 area, float depth, uint from, uint count) {
    float sum = abs(at(area, depth - area_middle_0.w));
    for (uint i = 0u; i < count; ++i) {
        vec4 one = turning[from + i].area;
        sum += abs(at(one.xyz, depth - one.w));
    }
    return sum;
}

vec3 ring_areas(float depth) {
    return vec3(ring_area(area_middle_0.xyz, depth, first.x, listed.x),
                ring_area(area_bias_1.xyz, depth, first.y, listed.y),
                ring_area(area_cell_2.xyz, depth, first.z, listed.z));
}

vec3 starts() { return vec3(flux_start_0.w, flux_start_1.w, flux_start_2.w); }

vec3 barycentric(vec3 w) {
    float sum = w.x + w.y + w.z;
    return sum == 0.0 ? vec3(1.0 / 3.0) : w / sum;
}

// W/m^2 through the plane of constant depth. At a point, where a whole ring has no area, there is no density.
vec3 density(vec3 share, vec3 area) {
    vec3 part = vec3(area.x > 0.0 ? share.x / area.x : 0.0, area.y > 0.0 ? share.y / area.y : 0.0,
                     area.z > 0.0 ? share.z / area.z : 0.0);
    return part.x * flux_start_0.xyz + part.y * flux_start_1.xyz + part.z * flux_start_2.xyz;
}

// m a m of depth: along the light at a point.
vec3 along_light(vec3 share) { return vec3(share.x * ray_0.zw + share.y * ray_1.zw + share.z * ray_2.zw, 1.0); }

vec2 place(vec4 ray, vec3 point) { return ray.xy + ray.zw * point.z - point.xy; }

vec3 lit(vec3 point, vec3 normal) {
    vec2 p0 = place(ray_0, point), p1 = place(ray_1, point), p2 = place(ray_2, point);
    vec3 w = vec3(side(p1, p2), side(p2, p0), side(p0, p1));
    if (!one_sign(w)) return vec3(0.0);
    vec3 share = barycentric(w);
    float below = point.z - dot(share, starts());
    if (below < -area_bias_1.w || point.z > dot(share, ends) + area_bias_1.w) return vec3(0.0);
    vec3 light = along_light(share);
    float facing = -dot(light.x * frame.a + light.y * frame.b + light.z * frame.axis, normal);
    if (facing <= 0.0) return vec3(0.0);
    return facing * density(share, ring_areas(point.z)) *
           exp(-push.extinction * (max(below, 0.0) * length(light)));
}

// The beam along a camera ray: t is m from `base`.
struct Along {
    vec3 w0, w1, w2;  // m^2: c0 + c1 t + c2 t^2 beside the edges that face the corners
    float depth, deeper;
    vec3 direction;
    float base;  // m from the camera's end of the segment
};

vec3 sides(Along ray, float t) { return vec3(at(ray.w0, t), at(ray.w1, t), at(ray.w2, t)); }

vec3 edge(vec2 p, vec2 p_along, vec2 q, vec2 q_along) {
    vec3 c = vec3(cross_2(p, q), 0.0, cross_2(p_along, q_along));
    precise float forth = cross_2(p, q_along);
    precise float back = cross_2(q, p_along);
    c.y = forth - back;
    if (c == vec3(0.0)) c.x = tie(q - p + (q_along - p_along));
    return c;
}

// Where an edge is crossed; far away: not at all.
vec2 roots(vec3 c) {
    float discriminant = c.y * c.y - 4.0 * c.x * c.z;
    if (discriminant < 0.0) return vec2(1e30);
    float q = -0.5 * (c.y + (c.y < 0.0 ? -sqrt(discriminant) : sqrt(discriminant)));
    return vec2(c.z == 0.0 ? 1e30 : q / c.z, q == 0.0 ? 1e30 : c.x / q);
}

// Positive where the point is within the start (cap -1) or the end (cap 1) of the beam, up to a positive factor.
float within(Along ray, float t, float cap) {
    vec3 w = sides(ray, t);
    float depth = ray.depth + t * ray.deeper;
    vec3 room = cap > 0.0 ? ends - depth : depth - starts();
    return dot(abs(w), room + area_bias_1.w);
}

// Cuts a piece at a cap, by false position (the Illinois rule).
void cut(Along ray, float cap, inout float from, inout float to) {
    float a = from, b = to, fa = within(ray, a, cap), fb = within(ray, b, cap);
    if (fa >= 0.0 && fb >= 0.0) return;
    if (fa < 0.0 && fb < 0.0) {
        to = from;
        return;
    }
    for (int i = 0; i < 5; ++i) {
        float c = (fa * b - fb * a) / (fa - fb), fc = within(ray, c, cap);
        if (fc < 0.0 == fb < 0.0) {
            b = c;
            fb = fc;
            fa *= 0.5;
        } else {
            a = c;
            fa = fc;
            fb *= 0.5;
        }
    }
    float c = (fa * b - fb * a) / (fa - fb);
    if (within(ray, from, cap) < 0.0)
        from = c;
    else
        to = c;
}

vec3 scattered_at(Along ray, float t) {
    vec3 share = barycentric(sides(ray, t));
    float depth = ray.depth + t * ray.deeper;
    vec3 light = along_light(share);
    float stretch = length(light);
    float way = max(0.0, depth - dot(share, starts())) * stretch + ray.base + t;
    float p = phase(-dot(light, ray.direction) / stretch);
    return (p * stretch) * density(share, ring_areas(depth)) * exp(-push.extinction * way);
}

// Nodes and weights of Gauss and Legendre's rule of degree five.
const float kNode = 0.774596669;
const float kOuter = 5.0 / 9.0;
const float kInner = 8.0 / 9.0;
const int kMostPanels = 8;

vec3 integral(Along ray, float from, float to) {
    // Densities change as the areas do: where these change by much the piece is cut.
    vec3 a = ring_areas(ray.depth + from * ray.deeper), b = ring_areas(ray.depth + 0.5 * (from + to) * ray.deeper),
         c = ring_areas(ray.depth + to * ray.deeper);
    vec3 least = min(min(a, b), c), most = max(max(a, b), c);
    vec3 span = most / max(least, most * 1e-3);
    float change = max(max(span.x, span.y), span.z);
    float panels_of_change = change > 1.5 ? 2.0 * log2(min(change, 1e3)) + 1.0 : 1.0;
    float dimming = (max(max(push.extinction.x, push.extinction.y), push.extinction.z)) *
                    (to - from) * (1.0 + abs(ray.deeper) * length(along_light(vec3(1.0 / 3.0))));
    int panels = int(min(max(panels_of_change, dimming), float(kMostPanels)));
    vec3 sum = vec3(0.0);
    float half_width = 0.5 * (to - from) / float(panels);
    for (int i = 0; i < panels; ++i) {
        float middle = from + (2.0 * float(i) + 1.0) * half_width;
        for (int node = -1; node <= 1; ++node)
            sum += (node == 0 ? kInner : kOuter) * scattered_at(ray, middle + float(node) * kNode * half_width);
    }
    return sum * half_width * push.scattering;
}

vec3 scatter(vec3 origin, vec3 direction, float segment) {
    vec2 p0 = place(ray_0, origin), p1 = place(ray_1, origin), p2 = place(ray_2, origin);
    vec2 d0 = ray_0.zw * direction.z - direction.xy, d1 = ray_1.zw * direction.z - direction.xy,
         d2 = ray_2.zw * direction.z - direction.xy;
    // Where the segment is in the beam's range of depths.
    vec3 start = starts();
    float low = min(min(start.x, start.y), start.z) - area_bias_1.w;
    float high = max(max(ends.x, ends.y), ends.z) + area_bias_1.w;
    float from = 0.0, to = segment;
    if (direction.z != 0.0) {
        float t0 = (low - origin.z) / direction.z, t1 = (high - origin.z) / direction.z;
        from = max(from, min(t0, t1));
        to = min(to, max(t0, t1));
    } else if (origin.z < low || origin.z > high) {
        return vec3(0.0);
    }
    if (!(from < to)) return vec3(0.0);
    // Edges are measured from a place near the beam, where few digits are lost; neighbours mostly take the same.
    vec2 p = (p0 + p1 + p2) / 3.0, d = (d0 + d1 + d2) / 3.0;
    float nearest = clamp(-dot(p, d) / max(dot(d, d), 1e-12), from, to);
    float base = round(nearest / area_cell_2.w) * area_cell_2.w;
    vec3 point = origin + base * direction;
    p0 = place(ray_0, point);
    p1 = place(ray_1, point);
    p2 = place(ray_2, point);
    Along ray;
    ray.w0 = edge(p1, d1, p2, d2);
    ray.w1 = edge(p2, d2, p0, d0);
    ray.w2 = edge(p0, d0, p1, d1);
    ray.depth = point.z;
    ray.deeper = direction.z;
    ray.direction = direction;
    ray.base = base;
    from -= base;
    to -= base;
    vec2 r0 = roots(ray.w0), r1 = roots(ray.w1), r2 = roots(ray.w2);
    vec3 sum = vec3(0.0);
    while (from < to) {
        float next = to;
        next = r0.x > from ? min(next, r0.x) : next;
        next = r0.y > from ? min(next, r0.y) : next;
        next = r1.x > from ? min(next, r1.x) : next;
        next = r1.y > from ? min(next, r1.y) : next;
        next = r2.x > from ? min(next, r2.x) : next;
        next = r2.y > from ? min(next, r2.y) : next;
        if (one_sign(sides(ray, 0.5 * (from + next)))) {
            float enter = from, leave = next;
            cut(ray, -1.0, enter, leave);
            cut(ray, 1.0, enter, leave);
            if (enter < leave) sum += integral(ray, enter, leave);
        }
        from = next;
    }
    return sum;
}

void main() {
    scattered = vec4(0.0, 0.0, 0.0, 1.0);
    irradiance = vec4(0.0);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 seen = texelFetch(pixels, pixel, 0);
    if (seen.z != push.in_water) return;
    vec2 xy = vec2(pixel);
    vec3 origin = push.origin + xy.x * push.origin_u + xy.y * push.origin_v;
    vec3 direction = normalize(push.direction + xy.x * push.direction_u + xy.y * push.direction_v);
    if (seen.x > 0.0) scattered.xyz = scatter(origin, direction, seen.x);
    if (seen.y > 0.0) irradiance.xyz = lit(origin + seen.y * direction, texelFetch(normals, pixel, 0).xyz);
}
