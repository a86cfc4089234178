#version 460
#extension GL_EXT_scalar_block_layout : require
// values[i] = factor * i
layout(local_size_x = 64) in;
layout(scalar, binding = 0) writeonly buffer Values { uint values[]; };
layout(scalar, push_constant) uniform Push { uint count; uint factor; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) values[i] = factor * i;
}
