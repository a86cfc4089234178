// One photon's splat, written by the host (eight at once: methods/photon_splatting/splat_builder.cpp counts
// on the order) and read by photon_splatting/splat*.vert, or by the host's own renderer. Positions and
// vectors are relative to the frame's origin.
#ifndef DAPPLE_LAYOUT_SPLAT
#define DAPPLE_LAYOUT_SPLAT
#include "layout/receiver.h"
#include "layout/types.h"
LAYOUT_BEGIN

// As the paper tells receivers:
const float kDepthBias = 0.01f;  // m, which it does not give: its unit
const float kEdgeOn = 1e-4f;     // cosine of a plane on whose edge the camera looks

struct Splat {
    vec3 position;    // m, where the beam lands
    float tolerance;  // m, receivers farther off the tangent plane are not lit; negative for light in the
                      // air, which lights none in the water: its magnitude counts
    vec3 axis_a;      // 1/m: dot(axis_a, x - position) is the kernel's first coordinate, in [-1, 1] on its
                      // support;
    float box_a;  //      perpendicular to the beam. Half-width of the box that widens the tent, in [0, 1),
                  //      or the box, in (0, 1)
    vec3 axis_b;  // 1/m, the second coordinate
    float box_b;
    vec3 irradiance;  // W/m^2 for a kernel value of 1
    vec3 normal;      // unit, of the tangent plane, towards the side that the light arrives from
    vec2 center;      // pixels, middle of the parallelogram center +- edge_a +- edge_b that the splat covers;
    vec2 edge_a;      // pixels; (half width, 0)
    vec2 edge_b;      // pixels; and (0, half height) of a box for a point sprite
};

struct SplatPush {
    vec2 picture;      // pixels, width and height
    vec3 camera;       // m, where the camera stands (perspective), or the unit direction towards it
    uint perspective;  // 1 or 0
};

LAYOUT_END
#endif
