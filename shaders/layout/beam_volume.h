// Structs of the rasterised beams (shaders/adaptive_beams/). Mesh space has its depth along z and its zero at
// the frame's origin.
#ifndef DAPPLE_LAYOUT_BEAM_VOLUME
#define DAPPLE_LAYOUT_BEAM_VOLUME
#include "layout/types.h"
LAYOUT_BEGIN

const uint kPhaseValues = 2048u;  // of a tabulated phase function

// What a fragment knows of its beam; corners k in 0, 1, 2. Areas A are those that a corner's ring of
// triangles has on the planes of constant depth: |area.x + area.y u + area.z u^2| [m^2] with
// u = depth - area.w, and on top of it those of the triangles listed for the beam, whose sign changes.
struct DrawnBeam {
    vec4 ray[3];       // m and m a m of depth: a, b at depth 0, slopes
    vec4 area[3];      // m^2, m, 1, and m: where the area is least, as digits are lost far from there
    vec3 flux[3];      // W a channel, of a corner's ring
    vec3 own_flux;     // W a channel, of the beam
    vec3 start;        // m, depths at which the corners' rays begin
    vec3 end;          // m, and end
    float start_bias;  // m of depth before the start that belong to the beam
    float end_bias;    // and beyond the end, on the object that it ends on
    uint first;        // of the beam's listed triangles
    uint last;         // and the one after its last
    int ends_on;       // object that its rays end on; negative: none
};

// A triangle of a ring whose area changes its sign on the beam's way.
struct TurningArea {
    vec4 area;     // m^2, m, 1, m; as in the beam
    uint corners;  // 1, 2, 4: it is of the rings of corners 0, 1, 2
};

// Camera rays of the pixels (x, y), in mesh space: origin + x origin_u + y origin_v, along
// direction + x direction_u + y direction_v, not unit; and the medium that the beams are in.
struct BeamPush {
    vec3 origin, origin_u, origin_v;           // m
    vec3 direction, direction_u, direction_v;  //
    vec3 extinction;                           // 1/m a channel
    vec3 scattering;                           // 1/m a channel
    vec3 phase;      // of two_lobe_phase, in its order; the last one negative: a table
    float in_water;  // 1 or 0
    vec2 shift;      // pixels, from the sample to the pixel's centre
    vec2 in_cell;    // cells: the sample in the part of the picture that it stands for, from the top left
};

// Axes of mesh space in the world.
struct BeamFrame {
    vec3 a, b, axis;  // unit
};

LAYOUT_END
#endif
