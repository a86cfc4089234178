#version 460
#extension GL_EXT_scalar_block_layout : require
// values[] = the texels of an image, row by row
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, binding = 0) writeonly buffer Values { vec4 values[]; };
layout(binding = 1) uniform sampler2D image;

void main() {
    ivec2 size = textureSize(image, 0);
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(texel, size))) values[texel.y * size.x + texel.x] = texelFetch(image, texel, 0);
}
