#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// The oracle's verdict on each edge of the grid.
#include "adaptive_beams/oracle_buffers.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < settings.count) verdicts[index] = edge_verdict_of(index, settings);
}
