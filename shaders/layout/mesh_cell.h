// One cell of a caustic mesh where it has landed, written by the host and read by caustic_mesh/cell*.vert.
// Positions are relative to the frame's origin.
#ifndef DAPPLE_LAYOUT_MESH_CELL
#define DAPPLE_LAYOUT_MESH_CELL
#include "layout/receiver.h"
#include "layout/types.h"
LAYOUT_BEGIN

// Two triangles, (0, 1, 2) and (0, 2, 3); irradiance is linear on each.
struct MeshCell {
    vec3 corner_0;  // m
    vec3 corner_1;
    vec3 corner_2;
    vec3 corner_3;
    vec3 irradiance_0;  // W/m^2
    vec3 irradiance_1;
    vec3 irradiance_2;
    vec3 irradiance_3;
    vec3 normal;      // unit, of the plane that it lies about, towards the side that the light arrives from
    float tolerance;  // m, receivers farther off the plane are not lit
    vec3 facing;      // dot with a receiver's normal: its cosine towards the light over the plane's
    float in_water;   // 1: lights receivers in the water, 0: in the air
    float disc;       // m^2, square of the width across the beam of a box with the variance of the sun's disc
    vec2 center;      // pixels, middle of the parallelogram center +- edge_a +- edge_b that the cell covers;
    vec2 edge_a;      // pixels; (half width, 0)
    vec2 edge_b;      // pixels; and (0, half height) of a box for a point sprite
};

struct MeshPush {
    vec4 row_x;     // of pixel_from_world, from positions relative to the frame's origin: x,
    vec4 row_y;     // y
    vec4 row_w;     // and w of homogeneous pixel coordinates
    vec4 filter_0;  // pixels: middle of the first layer's filter from its receivers' points; width, height
    vec4 filter_1;
    vec4 filter_2;
    vec4 filter_3;
    vec2 picture;  // pixels, width and height
};

LAYOUT_END
#endif
