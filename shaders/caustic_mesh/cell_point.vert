#version 460
#extension GL_GOOGLE_include_directive : require
// A cell as a point sprite: one vertex, a square about the box.
#include "caustic_mesh/cell_vertex.glsl"

void main() {
    MeshCell cell = cells[gl_VertexIndex];
    send_cell(cell);
    gl_Position = clip_from_pixel(cell.center);
    gl_PointSize = 2.0 * max(cell.edge_a.x, cell.edge_b.y);
}
