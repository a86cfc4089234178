#version 460
#extension GL_EXT_scalar_block_layout : require
// Corners of bounding volumes without their beams.
layout(scalar, binding = 0) readonly buffer Corners { vec3 corners[]; };  // x w and y w, pixels; w
layout(push_constant) uniform Push { vec2 picture; };
layout(location = 0) flat out vec4 color;

void main() {
    vec3 corner = corners[gl_VertexIndex];
    color = vec4(1.0);
    gl_Position = vec4(2.0 * corner.xy / picture - corner.z, 1e-5, corner.z);
}
