// Bounded media about a beam (layout/beam_media.h).
#include "layout/beam_media.h"
layout(scalar, binding = 5) readonly buffer Media {
    uint ray_entry, light_entry;  // floats of an entry
    DrawnMedium media[];
};
layout(scalar, binding = 6) readonly buffer RayColumns { float ray_columns[]; };      // an entry a pixel
layout(scalar, binding = 7) readonly buffer LightColumns { float light_columns[]; };  // an entry a ray
layout(scalar, binding = 8) readonly buffer Rays { BeamRays rays_of[]; };             // a beam

// m: integrals of density along the camera ray of the pixel whose entry begins at `entry`, up to three places.
vec3 columns_along_ray(uint medium, uint entry, vec3 t) {
    uint at = entry + media[medium].ray_first;
    float last = ray_columns[at + 2u];
    vec3 place = clamp((t - ray_columns[at]) * ray_columns[at + 1u], 0.0, last);
    vec3 whole = floor(min(place, last - 1.0));
    uvec3 before = uvec3(whole) + at + 3u;
    vec3 share = place - whole;
    return mix(vec3(ray_columns[before.x], ray_columns[before.y], ray_columns[before.z]),
               vec3(ray_columns[before.x + 1u], ray_columns[before.y + 1u], ray_columns[before.z + 1u]), share);
}

// The same along a ray of light.
float light_column(uint at, float below) {
    float last = light_columns[at + 2u];
    float place = clamp((below - light_columns[at]) * light_columns[at + 1u], 0.0, last);
    float whole = floor(min(place, last - 1.0));
    uint before = at + 3u + uint(whole);
    return mix(light_columns[before], light_columns[before + 1u], place - whole);
}

// The three rays of a beam's lattice about a place, and its shares of them; without any there are no shares.
struct Among {
    uvec3 at;  // of their entries in light_columns
    vec3 share;
};

Among among(int beam, vec3 share) {
    BeamRays rays = rays_of[beam];
    if (rays.cells == 0u) return Among(uvec3(0u), vec3(0.0));
    uint n = rays.cells;
    vec2 place = clamp(share.yz, 0.0, 1.0) * float(n);
    uint i = min(uint(place.x), n - 1u), j = min(uint(place.y), n - 1u - i);
    vec2 within = place - vec2(i, j);
    uint row = rays.first + i * (2u * n + 3u - i) / 2u + j, next = row + n + 1u - i;
    bool far = within.x + within.y > 1.0 && i + j + 2u <= n;
    return Among((far ? uvec3(next + 1u, row + 1u, next) : uvec3(row, next, row + 1u)) * light_entry,
                 far ? vec3(within.x + within.y - 1.0, 1.0 - within.x, 1.0 - within.y)
                     : vec3(1.0 - within.x - within.y, within.x, within.y));
}

// The same of a box, on the way to a point; `light` a m of depth.
float box_column(uint medium, vec3 point, vec3 light, float below, float way) {
    mat3 turn = mat3(media[medium].turn_x, media[medium].turn_y, media[medium].turn_z);
    vec3 at = turn * point + media[medium].shift, back = -(turn * light);
    back = mix(back, vec3(1e-20), equal(back, vec3(0.0)));
    vec3 low = (-1.0 - at) / back, high = (1.0 - at) / back;
    vec3 enters = min(low, high), leaves = max(low, high);
    float from = max(max(enters.x, enters.y), max(enters.z, 0.0)),
          to = min(min(leaves.x, leaves.y), min(leaves.z, below));
    return below > 0.0 ? max(0.0, to - from) / below * way * media[medium].thickest : 0.0;
}

// Optical depth, a channel, of the way of light that is a mean of the beam's rays to a point, `below` m of depth and
// `way` m after the last surface; `light` a m of depth. Along grids it is the mean of what the rays
// about it meet.
vec3 light_depth(int beam, vec3 share, vec3 point, vec3 light, float below, float way) {
    Among rays = among(beam, share);
    vec3 sum = push.extinction * way;
    for (uint m = 0u; m < uint(media.length()); ++m) {
        float column = 0.0;
        if (media[m].in_light == 0u) {
            column = box_column(m, point, light, below, way);
        } else if (rays.share != vec3(0.0)) {
            uvec3 at = rays.at + media[m].light_first;
            column = rays.share.x * light_column(at.x, below) + rays.share.y * light_column(at.y, below) +
                     rays.share.z * light_column(at.z, below);
        }
        sum += column * media[m].extinction;
    }
    return sum;
}

// Where optical depth changes as the column does, what a part of the ray sends on is its column times the mean of
// exp(-x) between the depths at its ends. `a_left`, `b_left`: exp(-a), exp(-b).
vec3 mean_transmittance(vec3 a, vec3 a_left, vec3 b, vec3 b_left) {
    vec3 change = b - a;
    vec3 near = sqrt(a_left * b_left) * (1.0 + change * change / 24.0);
    vec3 far = (a_left - b_left) / mix(vec3(1.0), change, notEqual(change, vec3(0.0)));
    return mix(far, near, lessThan(abs(change), vec3(0.1)));
}

// m: narrows a part of the ray to where any of the media scatters light.
void clip_to_media(uint entry, inout float from, inout float to) {
    if (push.scattering != vec3(0.0)) return;
    float first = 1e30, last = -1e30;
    for (uint m = 0u; m < uint(media.length()); ++m) {
        uint at = entry + media[m].ray_first;
        float begin = ray_columns[at], inverse = ray_columns[at + 1u];
        if (inverse == 0.0 || media[m].scattering == vec3(0.0)) continue;
        first = min(first, begin);
        last = max(last, begin + ray_columns[at + 2u] / inverse);
    }
    from = max(from, first);
    to = min(to, last);
}
