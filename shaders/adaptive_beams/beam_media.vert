#version 460
#extension GL_GOOGLE_include_directive : require
#define BOUNDED
#include "adaptive_beams/beam_vertex.glsl"
