// One of the fragment shaders of beams. LISTED: beams have listed triangles (else all areas keep their signs);
// TABLE: the phase function is a table (else two lobes); BOUNDED: there are bounded media (phase functions are tables or
// lobes, medium by medium).
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
#ifdef BOUNDED
#define FIRST_IMAGE 9
#endif
#include "adaptive_beams/camera_ray.glsl"
#ifdef BOUNDED
#include "adaptive_beams/media.glsl"
#endif
layout(location = 0) out vec4 scattered;   // W/m^2/sr; and 1, which counts fragments
layout(location = 1) out vec4 irradiance;  // W/m^2
#include "adaptive_beams/phase.glsl"

#include "adaptive_beams/beam_section.glsl"

vec2 place(vec4 ray, vec3 point) { return ray.xy + ray.zw * point.z - point.xy; }

#include "adaptive_beams/beam_surface.glsl"

// The beam along a camera ray: t is m from `base`.
struct Along {
    vec3 w0, w1, w2;  // m^2: c0 + c1 t + c2 t^2 beside the edges that face the corners
    float depth, deeper;
    vec3 direction;
    float base;  // m from the camera's end of the segment
    vec3 point;  // there
    vec2 spread;  // m^2, 1: the squares of the corners' distances from the ray are spread.x + spread.y t^2 in sum
    uint entry;   // of the pixel's columns
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
    return dot(abs(w), room + (cap > 0.0 ? kEndBias : start_bias()));
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

#ifndef BOUNDED
vec3 scattered_at(Along ray, float t, float depth, vec3 area) {
    vec3 share = barycentric(sides(ray, t));
    vec3 light = along_light(share);
    float inverse = inversesqrt(dot(light, light));
    float stretch = 1.0 / inverse;
    float way = max(0.0, depth - dot(share, starts())) * stretch + ray.base + t;
    float p = phase(-dot(light, ray.direction) * inverse);
    return (p * stretch) * density(share, area) * exp(-push.extinction * way);
}
#endif

// Nodes and weights of Gauss and Legendre's rule of degree five.
const float kNode = 0.774596669;
const float kOuter = 5.0 / 9.0;
const float kInner = 8.0 / 9.0;
// Panels of one piece for bounded media, and in all.
const float kMostForMedia = 24.0;
#ifdef BOUNDED
const int kMostPanels = 64;
#else
const int kMostPanels = 32;
#endif
// Optical depths beyond a piece's brighter end: what lies farther gives less than a millionth; and of the first panel.
const float kDarkness = 16.0;
const float kFirstDepth = 1.0;

// m that light goes in the medium by way of a place on the camera ray.
float way_by(Along ray, float t) {
    vec3 share = barycentric(sides(ray, t));
    float below = ray.depth + ray.deeper * t - dot(share, starts());
    return max(0.0, below) * length(along_light(share)) + ray.base + t;
}

#ifdef BOUNDED
// Optical depth of light's way to a place on the camera ray.
vec3 light_depth_at(Along ray, float t) {
    vec3 share = barycentric(sides(ray, t));
    vec3 light = along_light(share), point = ray.point + t * ray.direction;
    float below = max(0.0, point.z - dot(share, starts()));
    return light_depth(beam_index, share, point, light, below, below * length(light));
}

// What reaches a place along the beam through rings of these areas, W/m^2, times its way a m of depth; and the cosine to
// the camera's way.
vec3 arriving(Along ray, float t, vec3 area, out float cosine) {
    vec3 share = barycentric(sides(ray, t)), light = along_light(share);
    float stretch = length(light);
    cosine = -dot(light, ray.direction) / stretch;
    return stretch * density(share, area);
}

// m: of a panel from `place` on, so that it ends where a medium begins or ends, and is two voxels wide at most in one;
// `wide`: m that it may have in any case.
float within_media(Along ray, float place, float sense, float width, float wide) {
    for (uint m = 0u; m < uint(media.length()); ++m) {
        uint at = ray.entry + media[m].ray_first;
        float inverse = ray_columns[at + 1u];
        if (inverse == 0.0) continue;
        float begin = ray_columns[at] - ray.base, end = begin + ray_columns[at + 2u] / inverse;
        float enters = sense * ((sense > 0.0 ? begin : end) - place),
              leaves = sense * ((sense > 0.0 ? end : begin) - place);
        float least = 1e-3 * width;
        if (enters > least)
            width = min(width, enters);
        else if (leaves > least)
            width = min(width, min(leaves, max(max(2.0 * media[m].step, 2.0 / inverse), wide)));
    }
    return width;
}
#endif

// Of areas among the nodes of a panel, by a factor; of more the panel is halved.
#ifdef BOUNDED
const float kMostChange = 2.0;
#else
const float kMostChange = 4.0;
#endif

bool changes(vec3 a, vec3 b, vec3 c) {
    return any(greaterThan(max(max(a, b), c), kMostChange * min(min(a, b), c)));
}

// Of panels, by a factor: areas go with the square of the distance from a focus.
float growth(vec3 before, vec3 after) {
    vec3 change = after / before;
    return sqrt(clamp(min(min(change.x, change.y), change.z), 0.25, 4.0));
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
    // is wide against a channel's depth lies where that channel is dark. Where areas change by much they are cut too.
    float width = kFirstDepth / max(most * steep, 1e-20);
    float widest = length_left;
#ifdef BOUNDED
    // A rule of two nodes for what reaches them, after Gauss, on the halves' own columns times their mean
    // transmittances: a part of the ray scatters what its columns say, wherever within it they grow.
    const float kTwoNodes = 0.211324865;
    float dims = most * steep, at_near = 0.0;
    vec3 sum = vec3(0.0), depth = push.extinction * (ray.base + near) + light_depth_at(ray, near);
    for (uint m = 0u; m < uint(media.length()); ++m) {
        dims += media[m].steepest;
        depth += columns_along_ray(m, ray.entry, vec3(ray.base + near)).x * media[m].extinction;
    }
    vec3 left = exp(-depth);
    width = kFirstDepth / max(dims, 1e-20);
    float wide = length_left / kMostForMedia;
    for (int panel = 0; panel < kMostPanels && at_near < length_left; ++panel) {
        float place = near + sense * at_near, size = length_left - at_near;
        if (panel + 1 < kMostPanels)
            size = within_media(ray, place, sense, min(min(width, widest), size), wide);
        float here = sense * size, one_cosine, other_cosine;
        float one_t = place + kTwoNodes * here, other_t = place + (1.0 - kTwoNodes) * here;
        vec3 one_area, other_area, middle_area;
        ring_areas(ray.depth + ray.deeper * vec3(one_t, place + 0.5 * here, other_t), one_area, middle_area, other_area);
        if (changes(one_area, middle_area, other_area) && panel + 2 < kMostPanels) {
            widest = 0.5 * size;
            continue;
        }
        widest = max(widest, size) * growth(one_area, other_area);
        vec3 one = arriving(ray, one_t, one_area, one_cosine), other = arriving(ray, other_t, other_area, other_cosine);
        vec3 t = ray.base + vec3(place, place + 0.5 * here, place + here);
        vec3 middle_depth = push.extinction * t.y + light_depth_at(ray, place + 0.5 * here);
        vec3 last_depth = push.extinction * t.z + light_depth_at(ray, place + here);
        vec3 one_scatters = vec3(0.0), other_scatters = vec3(0.0);
        if (push.scattering != vec3(0.0)) {
            one_scatters = push.scattering * (0.5 * size * phase(one_cosine));
            other_scatters = push.scattering * (0.5 * size * phase(other_cosine));
        }
        for (uint m = 0u; m < uint(media.length()); ++m) {
            vec3 column = columns_along_ray(m, ray.entry, t), extinction = media[m].extinction;
            middle_depth += column.y * extinction;
            last_depth += column.z * extinction;
            if (column.x != column.z) {
                vec3 scattering = media[m].scattering;
                one_scatters += scattering * (abs(column.y - column.x) * phase_of(one_cosine, m));
                other_scatters += scattering * (abs(column.z - column.y) * phase_of(other_cosine, m));
            }
        }
        vec3 middle_left = exp(-middle_depth), last_left = exp(-last_depth);
        sum += one * one_scatters * mean_transmittance(depth, left, middle_depth, middle_left) +
               other * other_scatters * mean_transmittance(middle_depth, middle_left, last_depth, last_left);
        depth = last_depth;
        left = last_left;
        at_near += size;
        width *= 2.0;
    }
    return sum;
#else
    vec3 a, b, c;
    vec3 sum = vec3(0.0);
    float at_near = 0.0;
    for (int panel = 0; panel < kMostPanels && at_near < length_left; ++panel) {
        float half_width = 0.5 * (length_left - at_near);
        if (panel + 1 < kMostPanels) half_width = min(0.5 * min(width, widest), half_width);
        float middle = near + sense * (at_near + half_width);
        vec3 t = vec3(middle - kNode * half_width, middle, middle + kNode * half_width);
        vec3 depth = ray.depth + ray.deeper * t;
        ring_areas(depth, a, b, c);
        if (changes(a, b, c) && panel + 2 < kMostPanels) {
            widest = half_width;
            continue;
        }
        widest = max(widest, 2.0 * half_width) * growth(a, c);
        sum += half_width * (kOuter * (scattered_at(ray, t.x, depth.x, a) + scattered_at(ray, t.z, depth.z, c)) +
                             kInner * scattered_at(ray, t.y, depth.y, b));
        at_near += 2.0 * half_width;
        width *= 2.0;
    }
    return sum * push.scattering;
#endif
}

void order(inout float a, inout float b) {
    float least = min(a, b);
    b = max(a, b);
    a = least;
}

// Of |p| |q|: what a cross product of p and q is off by, several times rounding.
const float kNoise = 1e-6;

// Of a ray that passes a focus the sides' signs are those of rounding, where all corners coincide. Points in a beam are
// as near to its corners as these are to each other.
uint piece_bit(Along ray, float from, float to, uint bit) {
    float t = 0.5 * (from + to);
    vec3 w = sides(ray, t);
    bool certain = abs(w.x + w.y + w.z) > kNoise * (ray.spread.x + ray.spread.y * t * t);
    return from < to && one_sign(w) && certain ? bit : 0u;
}

// Places that edges are measured from lie so many of a beam's perimeters apart, or half as many; and m at least.
const float kCellOfPerimeter = 4.0;
const float kLeastCell = 1.0 / 131072.0;

vec3 scatter(vec3 origin, vec3 direction, float segment, uint entry) {
    vec2 p0 = place(ray_0, origin), p1 = place(ray_1, origin), p2 = place(ray_2, origin);
    vec2 d0 = ray_0.zw * direction.z - direction.xy, d1 = ray_1.zw * direction.z - direction.xy,
         d2 = ray_2.zw * direction.z - direction.xy;
    // Where the segment is in the beam's range of depths.
    vec3 start = starts();
    float low = min(min(start.x, start.y), start.z) - start_bias();
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
#ifdef BOUNDED
    clip_to_media(entry, from, to);
    if (from >= to) return vec3(0.0);
#endif
    // Edges are measured from a place near the beam, where few digits are lost: from multiples of a power of two, some
    // widths of the beam there, so that neighbours mostly take the same.
    float across = dot(d0, d0) + dot(d1, d1) + dot(d2, d2);
    float nearest = -(dot(p0, d0) + dot(p1, d1) + dot(p2, d2)) / max(across, 1e-12);
    nearest = clamp(nearest, from, max(from, to));
    vec2 q0 = p0 + nearest * d0, q1 = p1 + nearest * d1, q2 = p2 + nearest * d2;
    float perimeter = distance(q0, q1) + distance(q1, q2) + distance(q2, q0);
    float cell = max(uintBitsToFloat(floatBitsToUint(kCellOfPerimeter * perimeter) & 0x7f800000u), kLeastCell);
    float base = round(nearest / cell) * cell;
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
    ray.spread = vec2(dot(p0, p0) + dot(p1, p1) + dot(p2, p2), across);
    ray.base = base;
    ray.point = point;
    ray.entry = entry;
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
    CameraRay ray = camera_ray();
#ifdef BOUNDED
    uint entry = uint(ray.pixel.y * textureSize(pixels, 0).x + ray.pixel.x) * ray_entry;
    bool scatters = ray.segment > 0.0;
#else
    uint entry = 0u;
    bool scatters = push.scattering != vec3(0.0);
#endif
    if (scatters) scattered.xyz = scatter(ray.origin, ray.direction, ray.segment, entry);
    if (ray.receiver > 0.0) irradiance.xyz = lit(ray.origin + ray.receiver * ray.direction, ray.pixel);
}
