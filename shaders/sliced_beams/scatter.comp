#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Light that even water scatters out of the beams of a sheet towards the camera, a segment an invocation: walks the
// nodes of the pyramid slab by slab, finds the pieces of the segment that lie in beams, and adds up their light, always
// in the same order. After so much work it stops, to go on in the next dispatch.
// Loops are left at their heads only: llvmpipe of Mesa 22 takes what is computed in the iteration that leaves a loop
// from the last iteration of all invocations that go together. And it executes what no invocation needs, too: so
// pieces that need more than three nodes of a quadrature, which are few, are put off, to be worked many together.
#include "layout/scatter.h"
#include "sliced_beams/decay.glsl"
#include "sliced_beams/scatter_slices.glsl"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Slabs { ScatterSlab slabs[]; };
layout(scalar, binding = 1) readonly buffer Nodes { ScatterNode nodes[]; };
layout(scalar, binding = 2) readonly buffer Beams { ScatterBeam beams[]; };
layout(scalar, binding = 3) readonly buffer Rays { ScatterRay rays[]; };
layout(scalar, binding = 4) readonly buffer Stops { float stop_depths[]; };  // m, where an object stops a ray
layout(scalar, binding = 5) readonly buffer Phase { float phases[]; };
layout(scalar, binding = 6) readonly buffer Segments { ScatterSegment segments[]; };
layout(scalar, binding = 7) buffer Sums { ScatterSum sums[]; };
layout(scalar, push_constant) uniform Push { ScatterPush push; };

// Nodes, beams and parts of pieces after which a dispatch walks no further. The pieces that were put off till then, 79
// at most, are worked to their ends: up to some thousand parts each, where way through a thick medium ends near a focus.
const uint kMostWork = 4096;
const float kMostParts = 1024.0;  // of a piece
const float kOpaque = 60.0;       // optical depth that nothing is left after
const float kThinEnough = 1.0;    // optical depth that three nodes are enough for
const float kEvenEnough = 0.3;    // change of the area that they are
const float kLeastArea = 1e-30;   // m^2, twice a beam's: less is lost in rounding
const float kNode = 0.7745966692414834;  // of Gauss and Legendre's rule, with 0 and its negative

const uint kPiecesOfABeam = 8;  // at most: four parts, on both sides of its edges
const uint kPiecesOfANode = 64;
const uint kManyPieces = 16;  // put off: as many are worked together

ScatterSum sum;
uint work = 0;
uint later[kManyPieces + kPiecesOfANode];  // pieces: index of the node, and in its beams
uint later_count = 0;

// The segment in the sheet's axes, and the part of it that may lie in the beams of a node.
vec3 origin, direction;
float reach, room;             // m, where it ends; rounding of places, a few times more than can be
float part_middle, part_half;  // m along it
vec3 part_at, part_moves;      // origin + middle direction, half direction

// A beam: its index, its rays, the areas beside its edges, each from the lower index of a vertex to the higher, and
// twice its own.
uint taken;
uvec3 corner;
vec4 pass[3];
float starts[3];
vec3 edge[3];
bool turned[3];  // the edge runs the other way about the beam
vec3 area;
vec3 cuts;  // places between which the edges' areas are monotone, ascending

float edge_area(int k, float t) { return turned[k] ? -value(edge[k], t) : value(edge[k], t); }

#include "sliced_beams/scatter_light.glsl"

void take_part(float from, float to) {
    part_middle = 0.5 * (from + to);
    part_half = 0.5 * (to - from);
    part_at = origin + part_middle * direction;
    part_moves = part_half * direction;
}

void take_beam(uint index) {
    taken = index;
    corner = uvec3(beams[index].corner[0], beams[index].corner[1], beams[index].corner[2]);
    Place place[3];
    for (int k = 0; k < 3; ++k) {
        ScatterRay ray = rays[corner[k]];
        starts[k] = ray.start;
        precise vec2 moved = ray.pass.xy - ray.start * push.shift;
        pass[k] = vec4(moved, ray.pass.zw + push.shift);
        precise vec2 off = moved - part_at.xy;
        precise vec2 at = fma(vec2(part_at.z), pass[k].zw, off);
        precise vec2 moves = fma(vec2(part_moves.z), pass[k].zw, -part_moves.xy);
        place[k].at = at;
        place[k].moves = moves;
    }
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        turned[k] = corner[i] > corner[j];
        if (turned[k])
            edge[k] = beside_edge(place[j], place[i]);
        else
            edge[k] = beside_edge(place[i], place[j]);
    }
    // Not as the edges' sum, which loses digits where the point is far from the beam.
    Place side[2];
    for (int k = 0; k < 2; ++k) {
        vec4 from_first = pass[k + 1] - pass[0];
        side[k].at = fma(vec2(part_at.z), from_first.zw, from_first.xy);
        side[k].moves = part_moves.z * from_first.zw;
    }
    area = beside(side[0], side[1]);
    float x = turning_place(edge[0]), y = turning_place(edge[1]), z = turning_place(edge[2]);
    float low = min(x, y), high = max(x, y);
    cuts = vec3(min(low, z), max(low, min(high, z)), max(high, z));
}

// Where the segment lies in the beam between two cuts: .xy on the positive side of all edges, .zw on the negative;
// empty where the first end is not less than the second.
vec4 pieces_of(uint part) {
    float from = part == 0 ? -1.0 : cuts[part - 1], to = part == 3 ? 1.0 : cuts[part];
    vec4 found = vec4(from, to, from, to);
    for (int k = 0; k < 3; ++k) {
        bool starts_above = (value(edge[k], from) > 0.0) != turned[k];
        bool stops_above = (value(edge[k], to) > 0.0) != turned[k];
        float at = starts_above == stops_above ? 0.0 : crossing(edge[k], from, to);
        vec2 above = vec2(starts_above ? from : (stops_above ? at : to),
                          stops_above ? to : (starts_above ? at : from));
        vec2 below = vec2(starts_above ? (stops_above ? to : at) : from, stops_above ? (starts_above ? from : at) : to);
        found = vec4(max(found.x, above.x), min(found.y, above.y), max(found.z, below.x), min(found.w, below.y));
    }
    return found;
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
float place_of(float depth) {
    float below = depth - origin.z, most = 2.0 * reach + 1.0;
    if (abs(below) < most * abs(direction.z)) return below / direction.z;
    return (below < 0.0) == (direction.z < 0.0) ? most : -most;
}

void clip_to_slab(ScatterSlab slab, out float from, out float to) {
    from = 0.0;
    to = reach;
    if (direction.z == 0.0) {
        if (!(origin.z >= slab.from && origin.z < slab.to)) to = -1.0;
        return;
    }
    float first = place_of(slab.from), last = place_of(slab.to);
    from = max(from, min(first, last));
    to = min(to, max(first, last));
}

void clip_to_node(ScatterNode n, float slab_from, inout float from, inout float to) {
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

// Adds the light of the beams of a node on the part that has been taken, but for pieces that need more than that: these
// are put off.
void add_beams(uint node, uint first, uint count) {
    uint piece = 0;  // kPiecesOfABeam a beam: two to each part
    uint end = kPiecesOfABeam * count;
    while (piece < end) {
        // The next one; the beam has been taken where its first has been looked for.
        vec2 found = vec2(0.0);
        uint at = 0;
        while (!(found.x < found.y) && piece < end) {
            uint part = piece / 2 % 4;
            if (piece % kPiecesOfABeam == 0) {
                take_beam(first + piece / kPiecesOfABeam);
                ++sum.beams;
                ++work;
            }
            vec4 both = pieces_of(part);
            bool below = (piece & 1) != 0 || !(both.x < both.y);
            found = below ? both.zw : both.xy;
            at = below ? piece | 1 : piece;
            // The other side has one, too, where the beam turns over.
            bool last = part == 3 || cuts[part] >= 1.0;
            uint next = last ? (piece / kPiecesOfABeam + 1) * kPiecesOfABeam : (piece | 1) + 1;
            piece = !below && both.z < both.w ? piece + 1 : next;
        }
        if (found.x < found.y && !add_plain(found.x, found.y)) {
            later[later_count] = node * kPiecesOfANode + at;
            ++later_count;
        }
    }
}

void add_later(uint place) {
    uint node = place / kPiecesOfANode, piece = place % kPiecesOfANode;
    uint s = 0;
    for (uint i = 0; i + 1 < push.slabs; ++i) s += node >= slabs[i].end ? 1 : 0;
    ScatterSlab slab = slabs[s];
    float from, to;
    clip_to_slab(slab, from, to);
    ScatterNode n = nodes[node];
    clip_to_node(n, slab.from, from, to);
    take_part(from, to);
    take_beam(n.first_beam + piece / kPiecesOfABeam);
    vec4 both = pieces_of(piece / 2 % 4);
    float stops[3];
    for (int k = 0; k < 3; ++k) stops[k] = stop_depths[corner[k]];
    add_piece((piece & 1) != 0 ? both.z : both.x, (piece & 1) != 0 ? both.w : both.y, stops);
}

bool goes_on() { return work < kMostWork && later_count < kManyPieces; }

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    sum = sums[i];
    uint end = slabs[push.slabs - 1].end;
    if (sum.node >= end) return;
    ScatterSegment segment = segments[i];
    mat3 axes = mat3(push.axis_a, push.axis_b, push.axis_depth);
    origin = segment.origin * axes;
    direction = segment.direction * axes;
    reach = segment.reach;
    room = 8.0 / 8388608.0 * (abs(origin.x) + abs(origin.y) + abs(origin.z) + reach + push.largest);
    while (sum.node < end && work < kMostWork) {
        later_count = 0;
        for (uint s = 0; s < push.slabs; ++s) {
            ScatterSlab slab = slabs[s];
            float first, last;
            clip_to_slab(slab, first, last);
            if (first > last && sum.node < slab.end && goes_on()) sum.node = slab.end;
            while (sum.node < slab.end && goes_on()) {
                // The next finest node: a loop of its own, so that invocations that go together wait for each other.
                float from = first, to = last;
                uint node = sum.node, beam = 0, count = 0;
                while (sum.node < slab.end && count == 0) {
                    node = sum.node;
                    ScatterNode n = nodes[node];
                    from = first;
                    to = last;
                    clip_to_node(n, slab.from, from, to);
                    bool met = from <= to;
                    sum.node = met ? node + 1 : n.next;
                    beam = n.first_beam;
                    count = met ? n.beams : 0;
                    ++work;
                }
                if (count > 0) {
                    ++sum.clusters;
                    take_part(from, to);
                    add_beams(node, beam, count);
                }
            }
        }
        for (uint k = 0; k < later_count; ++k) add_later(later[k]);
    }
    sums[i] = sum;
}
