#version 460
#extension GL_GOOGLE_include_directive : require
#define LAYERS 4
#include "caustic_mesh/cell_fragment.glsl"

void main() {
    targets[0] = lit(positions_0, normals_0, push.filter_0);
    targets[1] = lit(positions_1, normals_1, push.filter_1);
    targets[2] = lit(positions_2, normals_2, push.filter_2);
    targets[3] = lit(positions_3, normals_3, push.filter_3);
}
