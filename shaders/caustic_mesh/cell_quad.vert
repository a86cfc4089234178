#version 460
#extension GL_GOOGLE_include_directive : require
// A cell too large or too slender for a point sprite: two triangles over its parallelogram.
#include "caustic_mesh/cell_vertex.glsl"

const vec2 kCorners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

void main() {
    MeshCell cell = cells[gl_VertexIndex / 6];
    send_cell(cell);
    vec2 corner = kCorners[gl_VertexIndex % 6];
    gl_Position = clip_from_pixel(cell.center + corner.x * cell.edge_a + corner.y * cell.edge_b);
}
