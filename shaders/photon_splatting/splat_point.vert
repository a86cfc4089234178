#version 460
#extension GL_GOOGLE_include_directive : require
// A splat as a point sprite: one vertex, a square about the box.
#include "photon_splatting/splat_vertex.glsl"

void main() {
    Splat splat = splats[gl_VertexIndex];
    send_splat(splat);
    gl_Position = clip_from_pixel(splat.center);
    gl_PointSize = 2.0 * max(splat.edge_a.x, splat.edge_b.y);
}
