#version 460
#extension GL_EXT_scalar_block_layout : require
// An indexed mesh seen along y: the raw cost of rastering a surface with two values a vertex.
struct Vertex {
    vec3 position;  // x and z in -1..1, y in 0..1
    vec3 normal;
};
layout(scalar, binding = 0) readonly buffer Vertices { Vertex vertices[]; };
layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;

void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    position = vertex.position;
    normal = vertex.normal;
    gl_Position = vec4(vertex.position.xz, 1.0 - vertex.position.y, 1.0);
}
