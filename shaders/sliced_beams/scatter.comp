#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Light that an even medium scatters out of the beams of a sheet towards the camera, a segment an invocation: walks
// the nodes of the pyramid slab by slab, finds the pieces of the segment that lie in beams, and adds up their light,
// always in the same order. After so much work it stops, to go on in the next dispatch.
// Loops are left at their heads only: llvmpipe of Mesa 22 takes what is computed in the iteration that leaves a loop from
// the last iteration of all invocations that go together.
#include "layout/scatter.h"
#include "sliced_beams/decay.glsl"
#include "sliced_beams/scatter_slices.glsl"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Slabs { ScatterSlab slabs[]; };
layout(scalar, binding = 1) readonly buffer Nodes { ScatterNode nodes[]; };
layout(scalar, binding = 2) readonly buffer Beams { ScatterBeam beams[]; };
layout(scalar, binding = 3) readonly buffer Rays { ScatterRay rays[]; };
layout(scalar, binding = 4) readonly buffer Phase { float phases[]; };
layout(scalar, binding = 5) readonly buffer Segments { ScatterSegment segments[]; };
layout(scalar, binding = 6) buffer Sums { ScatterSum sums[]; };
layout(scalar, push_constant) uniform Push { ScatterPush push; };

const uint kMostWork = 4096;      // nodes, beams and nodes of quadratures a dispatch
const float kOpaque = 60.0;       // optical depth that nothing is left after
const float kThinEnough = 1.0;    // optical depth that three nodes are enough for
const float kEvenEnough = 0.3;    // change of the area that they are
const float kLeastArea = 1e-30;   // m^2, twice a beam's: less is lost in rounding
const float kNode = 0.7745966692414834;  // of Gauss and Legendre's rule, with 0 and its negative

ScatterSum sum;
uint work = 0;

// The segment in the sheet's axes, and the part of it that may lie in the beams of a node.
vec3 origin, direction;
float part_middle, part_half;  // m along it
vec3 part_at, part_moves;      // origin + middle direction, half direction

// A beam: its rays, the areas beside its edges, each from the lower index of a vertex to the higher, and twice its own.
vec4 pass[3];
float start[3], stop[3];
vec3 edge[3];
bool turned[3];  // the edge runs the other way about the beam
vec3 area;
float flux;
bool is_cut;
float cuts[3];  // places between which the edges' areas are monotone

void take_part(float from, float to) {
    part_middle = 0.5 * (from + to);
    part_half = 0.5 * (to - from);
    part_at = origin + part_middle * direction;
    part_moves = part_half * direction;
}

void take_beam(uint index) {
    ScatterBeam beam = beams[index];
    flux = beam.flux;
    is_cut = beam.cut != 0;
    Place place[3];
    for (int k = 0; k < 3; ++k) {
        ScatterRay ray = rays[beam.corner[k]];
        start[k] = ray.start;
        stop[k] = ray.stop;
        precise vec2 moved = ray.pass.xy - ray.start * push.shift;
        pass[k] = vec4(moved, ray.pass.zw + push.shift);
        precise vec2 at = part_at.z * pass[k].zw + (moved - part_at.xy);
        precise vec2 moves = part_moves.z * pass[k].zw - part_moves.xy;
        place[k].at = at;
        place[k].moves = moves;
    }
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        turned[k] = beam.corner[i] > beam.corner[j];
        if (turned[k])
            edge[k] = beside_edge(place[j], place[i]);
        else
            edge[k] = beside_edge(place[i], place[j]);
    }
    // Not as the edges' sum, which loses digits where the point is far from the beam.
    Place side[2];
    for (int k = 0; k < 2; ++k) {
        vec4 from_first = pass[k + 1] - pass[0];
        side[k].at = part_at.z * from_first.zw + from_first.xy;
        side[k].moves = part_moves.z * from_first.zw;
    }
    area = beside(side[0], side[1]);
    float x = turning_place(edge[0]), y = turning_place(edge[1]), z = turning_place(edge[2]);
    float low = min(x, y), high = max(x, y);
    cuts[0] = min(low, z);
    cuts[1] = max(low, min(high, z));
    cuts[2] = max(high, z);
}

// What a beam has to offer, step by step: between two cuts, on the positive or the negative side of its edges.
bool take_piece(uint part, bool negative, out float enter, out float leave) {
    float from = part == 0 ? -1.0 : cuts[part - 1], to = part == 3 ? 1.0 : cuts[part];
    enter = from;
    leave = to;
    for (int k = 0; k < 3; ++k) {
        bool above = negative == turned[k];
        bool starts = (value(edge[k], from) > 0.0) == above, stops = (value(edge[k], to) > 0.0) == above;
        float at = starts == stops ? (starts ? to : from) : crossing(edge[k], from, to);
        enter = starts ? enter : max(enter, stops ? at : to);
        leave = stops ? leave : min(leave, starts ? at : from);
    }
    return enter < leave;
}

float edge_area(int k, float t) { return turned[k] ? -value(edge[k], t) : value(edge[k], t); }

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
    float begins = l1 * (start[1] - start[0]) + (l2 * (start[2] - start[0]) + start[0]);
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

// Light of a piece, or part of one, along which optical depth changes little.
void add_thin(float enter, float leave) {
    float middle = 0.5 * (enter + leave), half_length = 0.5 * (leave - enter);
    vec3 c = vec3(value(area, middle), half_length * (2.0 * area.z * middle + area.y), half_length * half_length * area.z);
    c = c.x < 0.0 ? -c : c;
    float even = 0.6 * c.z + c.x;
    vec3 area_at = vec3(even - kNode * c.y, c.x, even + kNode * c.y);
    vec3 weight = vec3(5.0, 8.0, 5.0) / 9.0 *
                  vec3(inverse_area(area_at.x), inverse_area(area_at.y), inverse_area(area_at.z));
    if (!(abs(c.y) + 3.0 * abs(c.z) <= kEvenEnough * c.x)) {
        ++sum.peaks;
        if (has_root(c))
            ++sum.foci;
        else
            weight = product_weights(c);
    }
    if (weight.x == 0.0 || weight.y == 0.0 || weight.z == 0.0) sum.dropped += 3;
    weight *= half_length * part_half * flux;
    vec3 light = vec3(0.0);
    for (int j = 0; j < 3; ++j) {
        Node n = node_at(middle + float(j - 1) * kNode * half_length);
        float scattered = (j == 0 ? weight.x : (j == 1 ? weight.y : weight.z)) * n.stretch * phase(n.squared_sine);
        float path = max(n.path, 0.0);
        light += scattered * vec3(decay(push.extinction.x * path), decay(push.extinction.y * path),
                                  decay(push.extinction.z * path));
    }
    sum.radiance += push.scattered * light;
}

// Light of a piece that lies within the beam, in the water and before what stops it: cut where nothing of the light is
// left, and into parts of little optical depth.
void add_lit(float enter, float leave) {
    float most = max(max(push.extinction.x, push.extinction.y), push.extinction.z);
    float least = min(min(push.extinction.x, push.extinction.y), push.extinction.z);
    float first = node_at(enter).path, last = node_at(leave).path;
    float way = abs(last - first);
    int parts = 1;
    if (way * most > kThinEnough) {
        float share = 1.0;
        if (least > 0.0) share = clamp((kOpaque / least - max(min(first, last), 0.0)) / way, 0.0, 1.0);
        float length = share * (leave - enter);
        if (first <= last)
            leave = enter + length;
        else
            enter = leave - length;
        parts = int(clamp(ceil(share * way * most / kThinEnough), 1.0, 1024.0));
    }
    float from = enter;
    for (int i = 1; i <= parts; ++i) {
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

void add_piece(float enter, float leave) {
    float first = enter * part_moves.z + part_at.z, last = leave * part_moves.z + part_at.z;
    bool starts = min(first, last) < max(max(start[0], start[1]), start[2]);
    bool stops = is_cut && max(first, last) > min(min(stop[0], stop[1]), stop[2]);
    if (starts || stops) ++sum.cut;
    float middle = 0.5 * (enter + leave);
    vec4 below = starts ? positive_parts(beyond(start, 1.0, middle), enter, leave) : vec4(enter, leave, leave, leave);
    for (int i = 0; i < 2; ++i) {
        vec2 wet = i == 0 ? below.xy : below.zw;
        if (!(wet.x < wet.y)) continue;
        vec4 lit = stops ? positive_parts(beyond(stop, -1.0, middle), wet.x, wet.y) : vec4(wet, wet.y, wet.y);
        for (int j = 0; j < 2; ++j) {
            vec2 piece = j == 0 ? lit.xy : lit.zw;
            if (!(piece.x < piece.y)) continue;
            ++sum.intervals;
            add_lit(piece.x, piece.y);
        }
    }
}

// What is left of [from, to] where c0 + c1 s >= 0. By the values at both ends, which overflow nowhere.
void clip(float c0, float c1, inout float from, inout float to) {
    float first = c0 + c1 * from, last = c0 + c1 * to, length = to - from;
    if (first < 0.0 && last < 0.0)
        to = from - 1.0;
    else if (first < 0.0)
        from = to - length * (last / (last - first));
    else if (last < 0.0)
        to = from + length * (first / (first - last));
}

// Place at which the segment has a depth, held to places about it: the same number for the two slabs that meet there.
float place_of(float depth, float length) {
    float below = depth - origin.z, most = 2.0 * length + 1.0;
    if (abs(below) < most * abs(direction.z)) return below / direction.z;
    return (below < 0.0) == (direction.z < 0.0) ? most : -most;
}

void clip_to_slab(ScatterSlab slab, float length, out float from, out float to) {
    from = 0.0;
    to = length;
    if (direction.z == 0.0) {
        if (!(origin.z >= slab.from && origin.z < slab.to)) to = -1.0;
        return;
    }
    float first = place_of(slab.from, length), last = place_of(slab.to, length);
    from = max(from, min(first, last));
    to = min(to, max(first, last));
}

void clip_to_node(ScatterNode n, float slab_from, float room, inout float from, inout float to) {
    float below = origin.z - slab_from;
    // The shift, times the depth from where the rays start.
    vec2 first = push.shift * n.first_start, last = push.shift * n.last_start;
    vec2 most = max(first, last), least = min(first, last), lean = origin.z * push.shift;
    vec4 limit = n.low_high + below * n.grows;
    vec4 grows = direction.z * (n.grows + push.shift.xxyy);
    clip(origin.x - (limit.x - most.x) - lean.x + room, direction.x - grows.x, from, to);
    clip((limit.y - least.x) + lean.x - origin.x + room, grows.y - direction.x, from, to);
    clip(origin.y - (limit.z - most.y) - lean.y + room, direction.y - grows.z, from, to);
    clip((limit.w - least.y) + lean.y - origin.y + room, grows.w - direction.y, from, to);
    clip(origin.z - n.first_start + room, direction.z, from, to);
    clip(n.stop - origin.z + room, -direction.z, from, to);
}

// Adds the light of the beams from `first` to before `end` on the part that has been taken.
void add_beams(uint first, uint end) {
    uint beam = first, part = 0;
    bool negative = false;
    while (beam < end) {
        float enter = 0.0, leave = 0.0;
        bool found = false;
        while (!found && beam < end) {
            if (part == 0 && !negative) {
                take_beam(beam);
                ++sum.beams;
                ++work;
            }
            found = take_piece(part, negative, enter, leave);
            if (negative) ++part;
            negative = !negative;
            if (!negative && (part == 4 || cuts[part - 1] >= 1.0)) {
                part = 0;
                ++beam;
            }
        }
        if (found) add_piece(enter, leave);
    }
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    sum = sums[i];
    if (sum.node >= slabs[push.slabs - 1].end) return;
    ScatterSegment segment = segments[i];
    mat3 axes = mat3(push.axis_a, push.axis_b, push.axis_depth);
    origin = segment.origin * axes;
    direction = segment.direction * axes;
    // Rounding of places; a few times more than can be.
    float room = 8.0 / 8388608.0 *
                 (abs(origin.x) + abs(origin.y) + abs(origin.z) + segment.reach + push.largest);
    uint node = sum.node;
    for (uint s = 0; s < push.slabs && work < kMostWork; ++s) {
        ScatterSlab slab = slabs[s];
        if (node >= slab.end) continue;
        float first, last;
        clip_to_slab(slab, segment.reach, first, last);
        if (first > last) node = slab.end;
        while (node < slab.end && work < kMostWork) {
            // The next finest node: a loop of its own, so that invocations that go together wait for each other there.
            float from = first, to = last;
            uint beam = 0, count = 0;
            while (node < slab.end && count == 0) {
                ScatterNode n = nodes[node];
                from = first;
                to = last;
                clip_to_node(n, slab.from, room, from, to);
                bool met = from <= to;
                node = met ? node + 1 : n.next;
                beam = n.first_beam;
                count = met ? n.beams_count : 0;
                ++work;
            }
            if (count > 0) {
                ++sum.clusters;
                take_part(from, to);
                add_beams(beam, beam + count);
            }
        }
    }
    sum.node = node;
    sums[i] = sum;
}
