#version 460
#extension GL_GOOGLE_include_directive : require
#define TABLE
#define LISTED
#include "adaptive_beams/beam_fragment.glsl"
