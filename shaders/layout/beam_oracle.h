// Structs of the oracle of adaptive beams (shaders/adaptive_beams/oracle*.comp). Lengths are metres,
// positions relative to the frame's origin.
#ifndef DAPPLE_LAYOUT_BEAM_ORACLE
#define DAPPLE_LAYOUT_BEAM_ORACLE
#include "layout/types.h"
LAYOUT_BEGIN

// One leg of a ray that is looked at.
struct OracleWay {
    vec3 start;      // m, where it leaves the last specular surface
    vec3 direction;  // unit, of travel
    float reach;     // m, to where it ends
    float share;     // of the light that it carries, mean over channels
    uint path;       // of the surfaces that it met; 0: there is no such leg
    uint in_water;   // 1 where it is in the water
};

// A ray of the light.
struct OracleVertex {
    vec3 position;  // m, of the first surface
    vec3 normal;    // unit, towards the light
    vec2 uv;        // texels of the light's view
    float depth;    // m, from the light's start; 0 where the ray misses the body
    float falloff;  // of a spot, relative to its axis, times its picture, over the brightest texel
    uint on_body;   // 1 where the ray meets the body
    uint ends;      // of all surfaces and ends of its legs
};

struct OracleEdge {
    uint first;   // vertex
    uint second;  // vertex
    uint middle;  // vertex, half way
};

struct OracleTriangle {
    uint corner[3];  // vertices
    uint edge[3];
};

struct OracleTexel {
    vec3 normal;   // unit, towards the light; 0 where the body is not met
    uint on_body;  // 1 where the body is met
    float light;   // as OracleVertex::falloff, mean over the texel; read where `textured`
};

struct OraclePush {
    vec3 camera;          // m
    vec3 right;           // unit, of the picture; world space
    vec3 up;              // unit
    vec3 forward;         // unit
    vec2 half_tangent;    // of the view's angles to the right and up; 0 for an orthographic camera
    vec2 half_size;       // m, of an orthographic camera's view; 0 otherwise
    float pixel_angle;    // rad a pixel; 0 for an orthographic camera
    float pixel_size;     // m a pixel of an orthographic camera; 0 otherwise
    float extinction;     // /m, of water about the camera, least of the channels; 0: it is in the air
    float tolerance;      // pixels that landing points may be off in narrow beams
    float least_outline;  // pixels: of cells that are split at outlines
    float texel_size;     // m that a texel of the light's view is wide; 0 for a lamp
    float texel_angle;    // rad, for a lamp; 0 for a sun
    float transmission;   // rad that a transmitted ray turns for a rad of the surface's normal
    float reflection;     // rad that a reflected one does
    uint texels;          // along each side of the light's view
    uint count;           // of invocations with something to do
    uint textured;        // 1: the light is a spot that throws a picture
};

LAYOUT_END
#endif
