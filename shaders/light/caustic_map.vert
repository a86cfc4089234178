#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Light-view raster of the water: projects its triangles along the light onto the rest plane.
#include "layout/caustic_map.h"

layout(scalar, binding = 0) readonly buffer Positions { vec3 positions[]; };  // x, height above the rest plane, z; m
layout(scalar, binding = 1) readonly buffer Normals { vec3 normals[]; };
layout(scalar, push_constant) uniform Push { CausticMapPush push; };
layout(location = 0) out vec4 surface;

void main() {
    vec3 p = positions[gl_VertexIndex];
    float w = 1.0 - push.inverse_height * p.y;
    vec2 map = p.xz - push.shear * p.y;
    vec2 clip = push.clip_scale.xy * map.x + push.clip_scale.zw * map.y;
    gl_Position = vec4(clip + w * push.clip_offset, push.depth.x + push.depth.y * p.y, w);
    surface = vec4(p.y, normals[gl_VertexIndex]);
}
