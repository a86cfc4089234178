#version 460
// Height and normal of the water surface; where the surface lies follows exactly from the texel and the height.
layout(location = 0) in vec4 surface;
layout(location = 0) out vec4 texel;

void main() { texel = surface; }
