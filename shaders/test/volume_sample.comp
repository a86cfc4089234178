#version 460
#extension GL_EXT_scalar_block_layout : require
// values[i] = a 3-D image at texel coordinates points[i]
layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Points { vec3 points[]; };
layout(scalar, binding = 1) writeonly buffer Values { float values[]; };
layout(binding = 2) uniform sampler3D volume;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(points.length())) values[i] = textureLod(volume, points[i] / vec3(textureSize(volume, 0)), 0.0).x;
}
