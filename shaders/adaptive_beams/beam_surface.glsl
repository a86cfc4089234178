// What one beam sends to the receiver of one pixel: E, mean over the part of the picture that the pixel's sample stands
// for (its cell), laid on the receiver's tangent plane. Where the three rays of the beam meet that plane is a triangle;
// the part of it that lies in the cell is exact, so that beams much smaller than a pixel are seen too, with all of their
// flux. E of long beams has the density that is continuous from beam to beam; E of short ones, and of those without
// width, that which gives each beam its own flux: at a focus the areas of corners' rings are rounding.
// Needs what beam_fragment.glsl declares.
#include "light/square_coverage.glsl"

layout(binding = FIRST_IMAGE + 3) uniform sampler2D cells_right;  // of cells_down, and m^2 of a cell; 0: E at the point
layout(binding = FIRST_IMAGE + 4) uniform sampler2D cells_down;   // cells a m on the tangent plane, world space

// Cells: beams that are thinner where they land are widened to this, since sums over less are rounding.
const float kThinnest = 0.02;
// Cells that a beam is long where E is made of its own flux alone, and of the continuous density alone.
const float kShort = 1.0;
const float kLong = 4.0;
// Cells that a beam is thick where rounding has its area, and its rings'. Thicker ones beside folds have their flux in
// their rings' too, so that their own would be a second one.
const float kResolved = 1e-4;
// Cosine to a tangent plane, about, of rays that are taken to miss it.
const float kGrazing = 1e-4;

// Where a beam lights a receiver.
struct Landed {
    vec3 share;    // barycentric coordinates
    vec3 point;    // m, mesh space
    float slack;   // m of depth beyond its end that the beam lights the object that it ends on
    vec3 density;  // W/m^2 through the plane of constant depth, of what the cell or point has of it
};

vec3 to_mesh(vec3 v) { return vec3(dot(v, frame.a), dot(v, frame.b), dot(v, frame.axis)); }

bool land_at_point(vec3 point, vec2 p0, vec2 p1, vec2 p2, out Landed landed) {
    vec3 w = vec3(side(p1, p2), side(p2, p0), side(p0, p1));
    vec3 share = barycentric(w), area, same, again;
    ring_areas(vec3(point.z), area, same, again);
    landed = Landed(share, point, 0.0, density(share, area));
    return one_sign(w);
}

// Makes a triangle as thick as kThinnest: its apex over the longest edge is moved.
void widen(inout vec2 c0, inout vec2 c1, inout vec2 c2, vec2 along, bvec3 apex, float longest, float twice) {
    if (longest < kThinnest) {
        vec2 middle = (c0 + c1 + c2) / 3.0;
        c0 = middle + kThinnest * vec2(-0.5, -1.0 / 3.0);
        c1 = middle + kThinnest * vec2(0.5, -1.0 / 3.0);
        c2 = middle + kThinnest * vec2(0.0, 2.0 / 3.0);
        return;
    }
    vec2 move = vec2(-along.y, along.x) / longest * ((twice < 0.0 ? -kThinnest : kThinnest) - twice / longest);
    c0 += apex.x ? move : vec2(0.0);
    c1 += apex.y ? move : vec2(0.0);
    c2 += apex.z ? move : vec2(0.0);
}

bool land_in_cell(vec3 point, vec2 p0, vec2 p1, vec2 p2, vec3 plane, vec3 facing, vec4 right, vec3 down,
                  out Landed landed) {
    // From the point to where the rays meet the plane: m of depth, and in cells.
    vec3 deeper = -(plane.x * vec3(p0.x, p1.x, p2.x) + plane.y * vec3(p0.y, p1.y, p2.y)) / facing;
    vec3 x = to_mesh(right.xyz), y = to_mesh(down);
    vec3 q0 = vec3(p0 + ray_0.zw * deeper.x, deeper.x), q1 = vec3(p1 + ray_1.zw * deeper.y, deeper.y),
         q2 = vec3(p2 + ray_2.zw * deeper.z, deeper.z);
    vec2 c0 = vec2(dot(x, q0), dot(y, q0)) + push.in_cell, c1 = vec2(dot(x, q1), dot(y, q1)) + push.in_cell,
         c2 = vec2(dot(x, q2), dot(y, q2)) + push.in_cell;
    vec2 low = min(min(c0, c1), c2) - kThinnest, high = max(max(c0, c1), c2) + kThinnest;
    if (any(greaterThanEqual(low, vec2(1.0))) || any(lessThanEqual(high, vec2(0.0)))) return false;

    vec2 e0 = c2 - c1, e1 = c0 - c2, e2 = c1 - c0;
    vec3 lengths = vec3(length(e0), length(e1), length(e2));
    float longest = max(max(lengths.x, lengths.y), lengths.z);
    bvec3 apex = bvec3(lengths.x == longest, false, false);
    apex.y = !apex.x && lengths.y == longest;
    apex.z = !apex.x && !apex.y;
    float twice = cross_2(e1, e2), drawn = twice;
    if (abs(twice) < kThinnest * max(longest, kThinnest)) {
        widen(c0, c1, c2, apex.x ? e0 : apex.y ? e1 : e2, apex, longest, twice);
        drawn = cross_2(c0 - c2, c1 - c0);
    }
    vec3 part = barycentric_integrals(c0, c1, c2, edge_moments(c0, c1) + edge_moments(c1, c2) + edge_moments(c2, c0));
    float covered = part.x + part.y + part.z;
    if (covered <= 0.0) return false;
    landed.share = clamp(part / covered, 0.0, 1.0);
    landed.point = point + landed.share.x * q0 + landed.share.y * q1 + landed.share.z * q2;
    landed.slack = sqrt(right.w);
    float thickness = abs(twice) / max(longest, kThinnest) / kResolved;
    float own = clamp(max((kLong - longest) / (kLong - kShort), 2.0 - thickness), 0.0, 1.0);
    // m^2 of constant depth that the triangle has on the plane, as it is and as it is drawn.
    float to_area = 0.5 * right.w * -dot(landed.share, facing);
    float area_drawn = abs(drawn) * to_area;
    landed.density = flux_start_bias.xyz * (own * covered / area_drawn);
    if (own < 1.0) {
        // Where the corners land, which on a slanted plane differ in depth: all beams of a corner then have one density
        // there. No ring is smaller than its beam: it may be narrow where others of its beams do not land.
        vec3 of_0, of_1, of_2;
        ring_areas(point.z + deeper, of_0, of_1, of_2);
        vec3 area = max(vec3(of_0.x, of_1.y, of_2.z), vec3(abs(twice) * to_area));
        landed.density += density(part, area) * ((1.0 - own) * abs(twice / drawn));
    }
    return true;
}

vec3 lit(vec3 point, ivec2 pixel) {
    vec2 p0 = place(ray_0, point), p1 = place(ray_1, point), p2 = place(ray_2, point);
    // `face`: geometric normal and object.
    vec4 face = texelFetch(faces, pixel, 0), right = texelFetch(cells_right, pixel, 0);
    vec3 plane = to_mesh(face.xyz);
    vec3 facing = vec3(dot(plane.xy, ray_0.zw), dot(plane.xy, ray_1.zw), dot(plane.xy, ray_2.zw)) + plane.z;
    Landed landed;
    bool lights = right.w > 0.0 && all(lessThan(facing, vec3(-kGrazing)))
                      ? land_in_cell(point, p0, p1, p2, plane, facing, right, texelFetch(cells_down, pixel, 0).xyz, landed)
                      : land_at_point(point, p0, p1, p2, landed);
    if (!lights) return vec3(0.0);
    vec3 share = landed.share, end = ends();
    float below = landed.point.z - dot(share, starts());
    vec3 light = along_light(share);
    float cosine = -dot(light, to_mesh(texelFetch(normals, pixel, 0).xyz));
    // Of the object that its rays end on the beam lights all faces, wherever they lie between the rays; others only
    // where they are before the end.
    float last = face.w == float(listed_ends_on.z)
                     ? max(max(end.x, end.y), end.z) + end_bias.w + landed.slack
                     : dot(share, end);
    if (below < -start_bias() || landed.point.z > last || cosine <= 0.0 || dot(light, plane) >= 0.0) return vec3(0.0);
    below = max(below, 0.0);
#ifdef BOUNDED
    vec3 depth = light_depth(beam_index, share, landed.point, light, below, below * length(light));
#else
    vec3 depth = push.extinction * (below * length(light));
#endif
    return cosine * landed.density * exp(-depth);
}
