#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Columns of one bounded medium along lines, for tables (layout/beam_media.h). The density of a grid is read from
// dense bricks, with linear filtering: by Gauss's rule of two nodes on steps of a voxel at most.
#include "layout/beam_media.h"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Lines { MediaLine lines[]; };
layout(scalar, binding = 1) readonly buffer Bodies { MediaBody body; };
layout(scalar, binding = 2) readonly buffer Blocks { int brick_of[]; };
layout(scalar, binding = 3) writeonly buffer Columns { float columns[]; };
layout(binding = 4) uniform sampler3D bricks;
layout(scalar, push_constant) uniform Push { ColumnPush push; };

const int kCells = 8;  // along a brick; it has a voxel more
const float kMostSteps = 4096.0;  // between two places
const float kNode = 0.211324865;

float density(vec3 at) {
    ivec3 block = (ivec3(floor(at)) >> 3) - body.first_block;
    if (any(lessThan(block, ivec3(0))) || any(greaterThanEqual(block, body.blocks))) return 0.0;
    int brick = brick_of[(block.z * body.blocks.y + block.y) * body.blocks.x + block.x];
    if (brick < 0) return 0.0;
    ivec3 place = ivec3(brick, brick / body.bricks.x, brick / (body.bricks.x * body.bricks.y)) % body.bricks;
    vec3 in_brick = at - vec3(kCells * (block + body.first_block));
    return textureLod(bricks, (vec3((kCells + 1) * place) + in_brick + 0.5) * body.texel, 0.0).x;
}

void write(MediaLine line, uint at) {
    mat3 turn = mat3(body.turn_x, body.turn_y, body.turn_z);
    vec3 origin = turn * line.origin + body.shift, direction = turn * line.direction;
    vec3 to_low = (body.low - origin) / direction, to_high = (body.high - origin) / direction;
    float begin = line.begin, end = line.end;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0.0) {
            end = origin[axis] < body.low[axis] || origin[axis] > body.high[axis] ? begin : end;
        } else {
            begin = max(begin, min(to_low[axis], to_high[axis]));
            end = min(end, max(to_low[axis], to_high[axis]));
        }
    }
    bool meets = begin < end;
    // One a voxel, as far as there is room.
    uint places = 2u;
    if (meets && body.grid == 1u) {
        float voxels = ceil(min(length(direction) * (end - begin), 1e6));
        places = clamp(uint(voxels) + 1u, min(push.least, push.places), push.places);
    }
    float step = meets ? (end - begin) / float(places - 1u) : 0.0;
    columns[at] = begin;
    columns[at + 1u] = meets ? 1.0 / step : 0.0;
    columns[at + 2u] = float(places - 1u);
    float metres = length(line.direction) * body.density * step, sum = 0.0;
    float steps = clamp(ceil(length(direction) * step), 1.0, kMostSteps);
    for (uint k = 0u; k < places; ++k) {
        columns[at + 3u + k] = sum;
        if (body.grid == 0u) {
            sum += metres;
        } else if (meets) {
            float part = 0.0, start = begin + float(k) * step;
            for (float i = 0.0; i < steps; i += 1.0) {
                part += density(origin + (start + (i + kNode) / steps * step) * direction) +
                        density(origin + (start + (i + 1.0 - kNode) / steps * step) * direction);
            }
            sum += 0.5 * metres * part / steps;
        }
    }
}

void main() {
    uint all = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint i = gl_GlobalInvocationID.x; i < push.lines; i += all) {
        MediaLine line = lines[i];
        if (line.in_water == push.in_water) write(line, i * push.entry + push.first);
    }
}
