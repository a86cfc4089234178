// Structs of the coverage pass (shaders/sliced_beams/*.comp). Lengths are metres in the axes of one beam
// sheet, relative to the frame's origin; footprint coordinates are those in which a receiver's footprint is
// the unit square about 0.
#ifndef DAPPLE_LAYOUT_COVERAGE
#define DAPPLE_LAYOUT_COVERAGE
#include "layout/types.h"
LAYOUT_BEGIN

// The ray of a vertex of the water.
struct CoverageRay {
    vec4 pass;    // m, a and b where it passes the plane depth = 0; m a m of depth, its slopes
    float start;  // m, depth at which it leaves the water
};

// Eight beams that are found together.
struct CoverageCluster {
    uint beam[8];  // triangles of the water; 0xffffffff: none
    uint frame;    // that they are landed in; where receivers have frames of their own: not read
};

// Landing points on a plane in footprint coordinates: x = dot(along_x, point - position).
struct CoverageFrame {
    vec3 position;  // m
    vec3 normal;    // unit
    vec3 along_x;   // 1/m
    vec3 along_y;   // 1/m
};

struct LandedBeam {
    vec3 x, y;   // of the three corners, in the coordinates of the frame's footprint
    vec3 power;  // W a channel, after absorption
};

// Four receivers that are near each other go through one list of clusters.
struct CoverageBlock {
    uint first;  // of the list
    uint last;   // and the one after its last
};

// A receiver on the plane that beams are landed on.
struct PlanarReceiver {
    vec2 center;  // coordinates of the frame's footprint
    vec2 to_x;    // rows of the matrix from there to its own, about `center`
    vec2 to_y;
    float inverse_area;  // 1/m^2; 0: no receiver
};

// A receiver on a plane of its own.
struct CurvedReceiver {
    CoverageFrame frame;
    float inverse_area;  // 1/m^2; 0: no receiver
};

struct CoveragePush {
    vec3 absorption;  // 1/m a channel
    uint count;       // of invocations with something to do
};

LAYOUT_END
#endif
