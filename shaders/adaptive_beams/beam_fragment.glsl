// One of the fragment shaders of beams. LISTED: beams have listed triangles (else all areas keep their signs);
// TABLE: the phase function is a table (else two lobes).
//
// What one beam sends through one pixel: S, scattered once on the part of the camera's segment that lies in the
// beam, and E, at the receiver. On every plane of constant depth a beam is the triangle of its three rays; along a
// camera ray depth is linear, and so twice the areas of the triangles between the ray's point and the beam's edges
// are quadratics: the point is in the beam where all three have one sign, and they are its barycentric coordinates.
// The density of flux is that of the corners, interpolated: a corner's is the flux of its ring of triangles over their
// area (after Ernst et al. 2005), so that it is continuous across beams, and the sum over all triangles of area times
// mean density is the sum of their flux.
#extension GL_EXT_scalar_block_layout : require
#define WAY in
#include "adaptive_beams/beam_varyings.glsl"
#include "layout/beam_volume.h"

layout(scalar, binding = 2) readonly buffer Turning { TurningArea turning[]; };
layout(scalar, binding = 4) readonly buffer Frames { BeamFrame frame; };
// Length of the primary segment [m], way to the receiver [m], 0: none; whether they are in the water.
layout(binding = 5) uniform sampler2D pixels;
layout(binding = 6) uniform sampler2D normals;  // of receivers, world space
layout(binding = 7) uniform sampler2D faces;    // their geometric normals, and the objects that they are on
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

// m^2: of the corners' rings at three depths.
void ring_areas(vec3 depth, out vec3 a0, out vec3 a1, out vec3 a2) {
    vec3 u = depth - area_middle_0.w;
    a0 = abs(vec3(at(area_middle_0.xyz, u.x), at(area_bias_1.xyz, u.x), at(area_cell_2.xyz, u.x)));
    a1 = abs(vec3(at(area_middle_0.xyz, u.y), at(area_bias_1.xyz, u.y), at(area_cell_2.xyz, u.y)));
    a2 = abs(vec3(at(area_middle_0.xyz, u.z), at(area_bias_1.xyz, u.z), at(area_cell_2.xyz, u.z)));
#ifdef LISTED
    for (uint i = uint(listed_ends_on.x); i < uint(listed_ends_on.y); ++i) {
        TurningArea one = turning[i];
        vec3 of_corner = vec3(one.corners & 1u, one.corners >> 1 & 1u, one.corners >> 2 & 1u);
        a0 += abs(at(one.area, u.x)) * of_corner;
        a1 += abs(at(one.area, u.y)) * of_corner;
        a2 += abs(at(one.area, u.z)) * of_corner;
    }
#endif
}

vec3 ends() { return end_steepness.xyz; }

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

// `face`: as the texels of `faces`.
vec3 lit(vec3 point, vec3 normal, vec4 face) {
    vec2 p0 = place(ray_0, point), p1 = place(ray_1, point), p2 = place(ray_2, point);
    vec3 w = vec3(side(p1, p2), side(p2, p0), side(p0, p1));
    vec3 share = barycentric(w), end = ends();
    float below = point.z - dot(share, starts());
    vec3 light = along_light(share);
    vec3 way = light.x * frame.a + light.y * frame.b + light.z * frame.axis;
    float facing = -dot(way, normal);
    // Of the object that its rays end on the beam lights all faces, wherever they lie between the rays; others only
    // where they are before the end.
    float last = face.w == float(listed_ends_on.z)
                     ? max(max(end.x, end.y), end.z) + area_bias_1.w
                     : dot(share, end);
    if (!one_sign(w) || below < -area_bias_1.w || point.z > last || facing <= 0.0 || dot(way, face.xyz) >= 0.0) return vec3(0.0);
    vec3 area, same, again;
    ring_areas(vec3(point.z), area, same, again);
    return facing * density(share, area) * exp(-push.extinction * (max(below, 0.0) * length(light)));
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

// m of depth beyond its end that a beam lights a medium: rounding, and none of what lies behind thin things.
const float kEndBias = 1e-4;

// Positive where the point is within the start (cap -1) or the end (cap 1) of the beam, up to a positive factor.
float within(Along ray, float t, float cap) {
    vec3 w = sides(ray, t);
    float depth = ray.depth + t * ray.deeper;
    vec3 room = cap > 0.0 ? ends() - depth : depth - starts();
    return dot(abs(w), room + (cap > 0.0 ? kEndBias : area_bias_1.w));
}

// Cuts a piece at a cap, by false position (the Illinois rule).
void cut(Along ray, float cap, inout float from, inout float to) {
    float a = from, b = to, fa = within(ray, a, cap), fb = within(ray, b, cap);
    bool enters = fa < 0.0, leaves = fb < 0.0;
    if (enters && leaves) to = from;
    int left = enters != leaves ? 4 : 0;
    float c = a;
    while (left >= 0) {
        c = enters != leaves ? (fa * b - fb * a) / (fa - fb) : c;
        if (left <= 0) break;
        float fc = within(ray, c, cap);
        bool second = fc < 0.0 == leaves;
        a = second ? a : c;
        b = second ? c : b;
        fa = second ? 0.5 * fa : fc;
        fb = second ? fc : 0.5 * fb;
        --left;
    }
    if (enters && !leaves) from = c;
    if (leaves && !enters) to = c;
}

vec3 scattered_at(Along ray, float t, float depth, vec3 area) {
    vec3 share = barycentric(sides(ray, t));
    vec3 light = along_light(share);
    float inverse = inversesqrt(dot(light, light));
    float stretch = 1.0 / inverse;
    float way = max(0.0, depth - dot(share, starts())) * stretch + ray.base + t;
    float p = phase(-dot(light, ray.direction) * inverse);
    return (p * stretch) * density(share, area) * exp(-push.extinction * way);
}

// Nodes and weights of Gauss and Legendre's rule of degree five.
const float kNode = 0.774596669;
const float kOuter = 5.0 / 9.0;
const float kInner = 8.0 / 9.0;
// Panels of one piece for the change of densities, and in all.
const float kMostForDensity = 8.0;
const int kMostPanels = 32;
// Optical depths beyond a piece's brighter end: what lies farther gives less than a millionth; and of the first panel.
const float kDarkness = 16.0;
const float kFirstDepth = 1.0;

// m that light goes in the medium by way of a place on the camera ray.
float way_by(Along ray, float t) {
    vec3 share = barycentric(sides(ray, t));
    float below = ray.depth + ray.deeper * t - dot(share, starts());
    return max(0.0, below) * length(along_light(share)) + ray.base + t;
}

vec3 integral(Along ray, float from, float to) {
    // From the end by which the way is the shorter, along which light is dimmed; mostly the camera's.
    float length_left = to - from, way = way_by(ray, from), middle_way = way_by(ray, 0.5 * (from + to)),
          last_way = way_by(ray, to);
    bool back = last_way < way;
    float near = back ? to : from, sense = back ? -1.0 : 1.0;
    // m of way a m, at most and at least: between beams that cross they are not quite even.
    float first_half = 2.0 * sense * (middle_way - way), second_half = 2.0 * sense * (last_way - middle_way);
    float steep = max(0.0, max(first_half, second_half)) / max(length_left, 1e-20);
    float slow = max(0.0, min(first_half, second_half)) / max(length_left, 1e-20);
    float most = max(max(push.extinction.x, push.extinction.y), push.extinction.z);
    float least = min(min(push.extinction.x, push.extinction.y), push.extinction.z);
    length_left = min(length_left, kDarkness / max(least * slow, 1e-20));
    // Panels double in width from the near end, so that all channels are resolved where they are bright: a panel that
    // is wide against a channel's depth lies where that channel is dark. Where densities change by much, as the areas
    // do, they are cut too.
    float width = kFirstDepth / max(most * steep, 1e-20);
    float widest = length_left / clamp(ceil(length_left * end_steepness.w * abs(ray.deeper)), 1.0, kMostForDensity);
    vec3 a, b, c;
    vec3 sum = vec3(0.0);
    float at_near = 0.0;
    for (int panel = 0; panel < kMostPanels && at_near < length_left; ++panel) {
        float half_width = 0.5 * min(min(width, widest * 1.0001), length_left - at_near);
        float middle = near + sense * (at_near + half_width);
        vec3 t = vec3(middle - kNode * half_width, middle, middle + kNode * half_width);
        vec3 depth = ray.depth + ray.deeper * t;
        ring_areas(depth, a, b, c);
        sum += half_width * (kOuter * (scattered_at(ray, t.x, depth.x, a) + scattered_at(ray, t.z, depth.z, c)) +
                             kInner * scattered_at(ray, t.y, depth.y, b));
        at_near += 2.0 * half_width;
        width *= 2.0;
    }
    return sum * push.scattering;
}

void order(inout float a, inout float b) {
    float least = min(a, b);
    b = max(a, b);
    a = least;
}

uint piece_bit(Along ray, float from, float to, uint bit) {
    return from < to && one_sign(sides(ray, 0.5 * (from + to))) ? bit : 0u;
}

vec3 scatter(vec3 origin, vec3 direction, float segment) {
    vec2 p0 = place(ray_0, origin), p1 = place(ray_1, origin), p2 = place(ray_2, origin);
    vec2 d0 = ray_0.zw * direction.z - direction.xy, d1 = ray_1.zw * direction.z - direction.xy,
         d2 = ray_2.zw * direction.z - direction.xy;
    // Where the segment is in the beam's range of depths.
    vec3 start = starts();
    float low = min(min(start.x, start.y), start.z) - area_bias_1.w;
    vec3 end = ends();
    float high = max(max(end.x, end.y), end.z) + kEndBias;
    float from = 0.0, to = segment;
    if (direction.z != 0.0) {
        float t0 = (low - origin.z) / direction.z, t1 = (high - origin.z) / direction.z;
        from = max(from, min(t0, t1));
        to = min(to, max(t0, t1));
    } else {
        to = origin.z < low || origin.z > high ? from : to;
    }
    // Edges are measured from a place near the beam, where few digits are lost; neighbours mostly take the same.
    vec2 p = (p0 + p1 + p2) / 3.0, d = (d0 + d1 + d2) / 3.0;
    float nearest = clamp(-dot(p, d) / max(dot(d, d), 1e-12), from, max(from, to));
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
    to = max(from, to - base);
    // The pieces between places where edges are crossed.
    vec2 r0 = clamp(roots(ray.w0), from, to), r1 = clamp(roots(ray.w1), from, to),
         r2 = clamp(roots(ray.w2), from, to);
    float c0 = r0.x, c1 = r0.y, c2 = r1.x, c3 = r1.y, c4 = r2.x, c5 = r2.y;
    order(c0, c1);
    order(c2, c3);
    order(c4, c5);
    order(c0, c2);
    order(c3, c5);
    order(c1, c4);
    order(c0, c1);
    order(c2, c3);
    order(c4, c5);
    order(c1, c2);
    order(c3, c4);
    order(c2, c3);
    uint inside = piece_bit(ray, from, c0, 1u) | piece_bit(ray, c0, c1, 2u) | piece_bit(ray, c1, c2, 4u) |
                  piece_bit(ray, c2, c3, 8u) | piece_bit(ray, c3, c4, 16u) | piece_bit(ray, c4, c5, 32u) |
                  piece_bit(ray, c5, to, 64u);
    vec3 sum = vec3(0.0);
    while (inside != 0u) {
        uint bit = inside & (~inside + 1u);
        inside ^= bit;
        float enter = bit < 8u ? (bit == 1u ? from : bit == 2u ? c0 : c1)
                               : (bit == 8u ? c2 : bit == 16u ? c3 : bit == 32u ? c4 : c5);
        float leave = bit < 8u ? (bit == 1u ? c0 : bit == 2u ? c1 : c2)
                               : (bit == 8u ? c3 : bit == 16u ? c4 : bit == 32u ? c5 : to);
        cut(ray, -1.0, enter, leave);
        cut(ray, 1.0, enter, leave);
        sum += integral(ray, enter, leave);
    }
    return sum;
}

void main() {
    scattered = vec4(0.0, 0.0, 0.0, 1.0);
    irradiance = vec4(0.0);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 seen = texelFetch(pixels, pixel, 0);
    seen.xy = seen.z == push.in_water ? seen.xy : vec2(0.0);
    vec2 xy = vec2(pixel);
    vec3 origin = push.origin + xy.x * push.origin_u + xy.y * push.origin_v;
    vec3 direction = normalize(push.direction + xy.x * push.direction_u + xy.y * push.direction_v);
    if (push.scattering != vec3(0.0)) scattered.xyz = scatter(origin, direction, seen.x);
    if (seen.y > 0.0) {
        vec3 normal = texelFetch(normals, pixel, 0).xyz;
        irradiance.xyz = lit(origin + seen.y * direction, normal, texelFetch(faces, pixel, 0));
    }
}
