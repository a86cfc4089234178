// One of the fragment shaders of beams as in the paper (Liktor and Dachsbacher 2011, section 5): one area function a
// beam; the part of the camera ray in the beam from a scan plane; its middle as the only sample; the surface term as a
// test of the receiver's point. TABLE: the phase function is a table (else two lobes); BOUNDED: there are bounded
// media.
#extension GL_EXT_scalar_block_layout : require
#define WAY in
#include "adaptive_beams/paper_varyings.glsl"
#include "layout/beam_volume.h"

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

// W/m^2 through a section.
vec3 density(float y) {
    float section = abs(area.x + y * (area.y + y * area.z));
    return section > 0.0 ? flux / section : vec3(0.0);
}

// Barycentric coordinates of a point in its section.
vec3 coordinates(vec3 point, float y) {
    vec3 p0 = base_end_0.xyz + y * along_bias_0.xyz - point, p1 = base_end_1.xyz + y * along_1 - point,
         p2 = base_end_2.xyz + y * along_2 - point;
    vec3 w = vec3(dot(beam_normal, cross(p1, p2)), dot(beam_normal, cross(p2, p0)), dot(beam_normal, cross(p0, p1)));
    float sum = w.x + w.y + w.z;
    return sum == 0.0 ? vec3(1.0 / 3.0) : w / sum;
}

vec3 along_light(vec3 share) { return share.x * along_bias_0.xyz + share.y * along_1 + share.z * along_2; }

// m of depth after the last surface.
float below(vec3 point, vec3 share) {
    return max(0.0, point.z - dot(share, vec3(base_end_0.z, base_end_1.z, base_end_2.z)));
}

// m a m of depth, from m a m of y.
vec3 per_depth(vec3 light) { return light / max(light.z, 1e-6); }

float height(vec3 point) { return dot(beam_normal, point - base_end_0.xyz); }

vec3 lit(vec3 point, vec3 normal) {
    float y = height(point);
    vec3 share = coordinates(point, y);
    vec3 light = along_light(share);
    float facing = -dot(light.x * frame.a + light.y * frame.b + light.z * frame.axis, normal);
    float end = dot(share, vec3(base_end_0.w, base_end_1.w, base_end_2.w));
    bool inside = all(greaterThanEqual(share, vec3(0.0))) && y > -along_bias_0.w && y < end + along_bias_0.w;
    if (!inside || facing <= 0.0) return vec3(0.0);
#ifdef BOUNDED
    vec3 depth = light_depth(beam_index, share, point, per_depth(light), below(point, share), max(y, 0.0) * length(light));
#else
    vec3 depth = push.extinction * (max(y, 0.0) * length(light));
#endif
    return facing * density(y) * exp(-depth);
}

// Where a side of the scan triangle crosses the ray: widens [from, to].
void cross_ray(vec2 p, vec2 q, inout float from, inout float to) {
    if (p.y < 0.0 == q.y < 0.0) return;
    float t = p.x + (q.x - p.x) * p.y / (p.y - q.y);
    from = min(from, t);
    to = max(to, t);
}

// The scan triangle's corner on an edge of the beam: along the ray, and beside it.
vec2 scanned(vec3 base, vec3 along, vec3 scan, vec3 origin, vec3 direction, vec3 beside) {
    float y = dot(scan, origin - base) / dot(scan, along);
    vec3 from_origin = base + y * along - origin;
    return vec2(dot(from_origin, direction), dot(from_origin, beside));
}

vec3 scatter(vec3 origin, vec3 direction, float segment, uint entry) {
    vec3 scan = cross(direction, cross(direction, beam_normal));
    vec3 beside = cross(scan, direction);
    vec2 p0 = scanned(base_end_0.xyz, along_bias_0.xyz, scan, origin, direction, beside),
         p1 = scanned(base_end_1.xyz, along_1, scan, origin, direction, beside),
         p2 = scanned(base_end_2.xyz, along_2, scan, origin, direction, beside);
    float from = 1e30, to = -1e30;
    cross_ray(p0, p1, from, to);
    cross_ray(p1, p2, from, to);
    cross_ray(p2, p0, from, to);
    // Within the beam's length.
    float y0 = height(origin), dy = dot(beam_normal, direction);
    float highest = max(max(base_end_0.w, base_end_1.w), base_end_2.w);
    if (dy != 0.0) {
        float t0 = -y0 / dy, t1 = (highest - y0) / dy;
        from = max(from, min(t0, t1));
        to = min(to, max(t0, t1));
    }
    from = max(from, 0.0);
    // Not cut at what the segment ends on, but faded as it comes nearer than the beam is thick (Lorach 2007).
    float thickness = to - from;
    float soft = clamp((segment - from) / thickness, 0.0, 1.0);
    float t = from + 0.5 * thickness;
    vec3 point = origin + t * direction;
    float y = y0 + t * dy;
    vec3 share = clamp(coordinates(point, y), 0.0, 1.0);
    vec3 light = along_light(share / (share.x + share.y + share.z));
    float stretch = length(light);
    bool ended = y > dot(share, vec3(base_end_0.w, base_end_1.w, base_end_2.w)) + along_bias_0.w;
    // Not where the ray runs along the triangle's normal: there is no scan plane. The comparison drops NaN too.
    if (!(thickness > 0.0 && thickness < 1e6) || !(segment > 0.0) || ended) return vec3(0.0);
    float cosine = -dot(light, direction) / stretch, way = max(y, 0.0) * stretch;
#ifdef BOUNDED
    vec3 sum = push.scattering * (soft * thickness * phase(cosine));
    vec3 depth = push.extinction * t;
    for (uint m = 0u; m < uint(media.length()); ++m) {
        // Bounded ones end where the segment does.
        vec3 column = columns_along_ray(m, entry, vec3(from, t, from + thickness));
        sum += media[m].scattering * ((column.z - column.x) * phase_of(cosine, m));
        depth += column.y * media[m].extinction;
    }
    share /= share.x + share.y + share.z;
    depth += light_depth(beam_index, share, point, per_depth(light), below(point, share), way);
    return sum * density(y) * exp(-depth) * stretch;
#else
    return push.scattering * density(y) * exp(-push.extinction * (way + t)) *
           (soft * thickness * stretch * phase(cosine));
#endif
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
    if (ray.receiver > 0.0)
        irradiance.xyz = lit(ray.origin + ray.receiver * ray.direction, texelFetch(normals, ray.pixel, 0).xyz);
}
