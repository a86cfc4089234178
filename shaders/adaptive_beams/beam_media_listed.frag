#version 460
#extension GL_GOOGLE_include_directive : require
#define BOUNDED
#define LISTED
#include "adaptive_beams/beam_fragment.glsl"
