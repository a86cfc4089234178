#version 460
#extension GL_EXT_scalar_block_layout : require
// results[i] = values[i] + 1
layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Values { uint values[]; };
layout(scalar, binding = 1) writeonly buffer Results { uint results[]; };
layout(scalar, push_constant) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) results[i] = values[i] + 1;
}
