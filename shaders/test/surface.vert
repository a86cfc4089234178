#version 460
#extension GL_EXT_scalar_block_layout : require
// An indexed mesh with one value a vertex, in clip space: what light/caustic_map.vert leaves to the rasteriser.
struct Vertex {
    vec3 clip;
    vec4 value;
};
layout(scalar, binding = 0) readonly buffer Vertices { Vertex vertices[]; };
layout(location = 0) out vec4 surface;

void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    gl_Position = vec4(vertex.clip, 1.0);
    surface = vertex.value;
}
