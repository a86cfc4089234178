#version 460
#extension GL_GOOGLE_include_directive : require
#include "adaptive_beams/paper_vertex.glsl"
