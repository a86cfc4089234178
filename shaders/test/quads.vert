#version 460
#extension GL_EXT_scalar_block_layout : require
// Vertices given as pixel positions and a depth; the flat colour of a triangle is that of its first vertex.
struct Vertex {
    vec3 position;  // pixels from the top left, and depth in 0..1
    vec4 color;
};
layout(scalar, binding = 0) readonly buffer Vertices { Vertex vertices[]; };
layout(scalar, push_constant) uniform Push { vec2 size; };  // of the target, pixels
layout(location = 0) flat out vec4 color;

void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    gl_Position = vec4(vertex.position.xy / size * 2.0 - 1.0, vertex.position.z, 1.0);
    color = vertex.color;
}
