#version 460
#extension GL_GOOGLE_include_directive : require
#define BOXES 1
#define LAYERS 1
#include "photon_splatting/splat_fragment.glsl"

void main() { targets[0] = lit(receivers_0); }
