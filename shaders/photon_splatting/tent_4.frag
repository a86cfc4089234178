#version 460
#extension GL_GOOGLE_include_directive : require
#define LAYERS 4
#include "photon_splatting/splat_fragment.glsl"

void main() {
    targets[0] = lit(receivers_0);
    targets[1] = lit(receivers_1);
    targets[2] = lit(receivers_2);
    targets[3] = lit(receivers_3);
}
