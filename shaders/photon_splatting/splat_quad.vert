#version 460
#extension GL_GOOGLE_include_directive : require
// A splat too large or too slender for a point sprite: two triangles over its parallelogram.
#include "photon_splatting/splat_vertex.glsl"

const vec2 kCorners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

void main() {
    Splat splat = splats[gl_VertexIndex / 6];
    send_splat(splat);
    vec2 corner = kCorners[gl_VertexIndex % 6];
    gl_Position = clip_from_pixel(splat.center + corner.x * splat.edge_a + corner.y * splat.edge_b);
}
