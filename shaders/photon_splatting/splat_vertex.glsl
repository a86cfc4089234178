// What the vertex shaders of point sprites and of quads share.
#extension GL_EXT_scalar_block_layout : require
#include "layout/splat.h"

layout(scalar, binding = 0) readonly buffer Splats { Splat splats[]; };
layout(scalar, push_constant) uniform Push { SplatPush push; };
layout(location = 0) flat out vec4 position_tolerance;
layout(location = 1) flat out vec4 axis_a;  // and half-width of the box
layout(location = 2) flat out vec4 axis_b;
layout(location = 3) flat out vec4 irradiance;  // and medium: 1 in the water, 0 in the air
layout(location = 4) flat out vec3 normal;
layout(location = 5) flat out vec3 facing;  // dot with a receiver's normal: its cosine over the tangent plane's

void send_splat(Splat splat) {
    position_tolerance = vec4(splat.position, abs(splat.tolerance));
    axis_a = vec4(splat.axis_a, splat.box_a);
    axis_b = vec4(splat.axis_b, splat.box_b);
    irradiance = vec4(splat.irradiance, splat.tolerance < 0.0 ? 0.0 : 1.0);
    normal = splat.normal;
    // Both axes are perpendicular to the beam; the sign of their product cancels.
    vec3 beam = cross(splat.axis_a, splat.axis_b);
    facing = beam / dot(beam, splat.normal);
}

vec4 clip_from_pixel(vec2 pixel) { return vec4(pixel / push.picture * 2.0 - 1.0, 0.0, 1.0); }
