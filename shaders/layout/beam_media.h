// Bounded media as beams meet them (shaders/adaptive_beams/media*). A table of columns has an entry a line,
// and of each medium in it: the parameter of the line where it enters the medium's box, 1 over the step
// between places (0: it does not enter), the number of the last place on this line (1 at least), and the
// integral of density up to each place [m].
#ifndef DAPPLE_LAYOUT_BEAM_MEDIA
#define DAPPLE_LAYOUT_BEAM_MEDIA
#include "layout/types.h"
LAYOUT_BEGIN

// A part of a line origin + t direction: begin <= t <= end. Metres, relative to the frame's origin.
struct MediaLine {
    vec3 origin;     // m
    vec3 direction;  // m a unit of t
    float begin;     // of t
    float end;
    float in_water;  // 1 or 0: the side of the water that it is on
};

// Where a medium lies; its local space is -1 to 1 in a box, the index of a grid.
struct MediaBody {
    vec3 turn_x, turn_y, turn_z;  // columns: local = turn * position + shift
    vec3 shift;
    vec3 low, high;     // of the box that holds it, local
    float density;      // where a box is, or the texture is 1
    vec3 texel;         // 1 / texels of the texture
    ivec3 first_block;  // grids::DenseBricks
    ivec3 blocks;
    ivec3 bricks;
    uint grid;  // 1; 0: a box
};

// Rays of a beam along which columns of grids are known: a lattice in its barycentric coordinates. Ray (i, j)
// has the shares (cells - i - j, i, j) / cells of the beam's three rays; j runs fastest, i + j <= cells.
struct BeamRays {
    uint first;  // entry
    uint cells;  // along an edge; 0: the beam meets no grid
};

struct ColumnPush {
    uint lines;
    uint entry;      // floats of an entry
    uint first;      // of the medium in its entry
    uint places;     // on a line, at most; 2 at least
    uint least;      // of a grid, if it may have as many
    float in_water;  // lines that are looked at
};

// A medium as fragments see it. Tables are those of camera rays (t in m) and of the rays of beams (t in m of
// depth after the last surface).
struct DrawnMedium {
    vec3 extinction;   // 1/m where density is 1
    vec3 scattering;   // the same
    vec3 lobes;        // of two_lobe_phase, in its order
    int phase_table;   // first value of the phase function in the tables; negative: two lobes
    float step;        // m: a voxel's width
    float steepest;    // 1/m: how fast optical depth grows along the camera and the light, at most
    float thickest;    // greatest density
    uint ray_first;    // of the medium in a camera ray's entry
    uint light_first;  // of the medium in a beam's ray's entry
    uint in_light;     // 0: a box, of which light's columns are found from where it lies
    // Of a box: local = turn * position + shift, from mesh space; local is -1 to 1.
    vec3 turn_x, turn_y, turn_z;  // columns
    vec3 shift;
};

LAYOUT_END
#endif
