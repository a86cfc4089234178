#version 460
#extension GL_GOOGLE_include_directive : require
#define LAYERS 1
#include "caustic_mesh/cell_fragment.glsl"

void main() { targets[0] = lit(positions_0, normals_0, push.filter_0); }
