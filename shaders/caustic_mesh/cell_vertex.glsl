// What the vertex shaders of point sprites and of quads share.
#extension GL_EXT_scalar_block_layout : require
#include "layout/mesh_cell.h"

layout(scalar, binding = 0) readonly buffer Cells { MeshCell cells[]; };
layout(scalar, push_constant) uniform Push { MeshPush push; };
layout(location = 0) flat out vec4 corner_0;  // and normal.x
layout(location = 1) flat out vec4 corner_1;  // and normal.y
layout(location = 2) flat out vec4 corner_2;  // and normal.z
layout(location = 3) flat out vec4 corner_3;  // and tolerance
layout(location = 4) flat out vec4 irradiance_0;  // and facing.x
layout(location = 5) flat out vec4 irradiance_1;  // and facing.y
layout(location = 6) flat out vec4 irradiance_2;  // and facing.z
layout(location = 7) flat out vec4 irradiance_3;  // and medium
layout(location = 8) flat out float disc;

void send_cell(MeshCell cell) {
    corner_0 = vec4(cell.corner_0, cell.normal.x);
    corner_1 = vec4(cell.corner_1, cell.normal.y);
    corner_2 = vec4(cell.corner_2, cell.normal.z);
    corner_3 = vec4(cell.corner_3, cell.tolerance);
    irradiance_0 = vec4(cell.irradiance_0, cell.facing.x);
    irradiance_1 = vec4(cell.irradiance_1, cell.facing.y);
    irradiance_2 = vec4(cell.irradiance_2, cell.facing.z);
    irradiance_3 = vec4(cell.irradiance_3, cell.in_water);
    disc = cell.disc;
}

vec4 clip_from_pixel(vec2 pixel) { return vec4(pixel / push.picture * 2.0 - 1.0, 0.0, 1.0); }
