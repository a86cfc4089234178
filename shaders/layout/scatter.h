// Structs of the pass that finds light scattered out of beams (shaders/sliced_beams/scatter.comp). Lengths
// are metres in the axes of one beam sheet, relative to the frame's origin, but for segments, which are in
// the world's axes.
#ifndef DAPPLE_LAYOUT_SCATTER
#define DAPPLE_LAYOUT_SCATTER
#include "layout/types.h"
LAYOUT_BEGIN

// The ray of a vertex of the water.
struct ScatterRay {
    vec4 pass;    // m, a and b where it passes the plane depth = 0; m a m of depth, its slopes
    float start;  // m, depth at which it leaves the water
};

struct ScatterBeam {
    uint corner[3];    // indices of rays
    vec3 flux;         // twice the beam's, of each channel, unit of BeamSheet::flux
    float last_start;  // m, depth from which on all of it is below the water
    float first_stop;  // m, depth from which on an object may have stopped it
};

// A node of the pyramid over the beams within one slab of depths. Nodes stand before their children, each
// followed by all that lies below it.
struct ScatterNode {
    vec4 low_high;      // m, bounds at the slab's first depth: of a from and to, of b from and to
    vec4 grows;         // m a m of depth, by how much they grow
    float first_start;  // m, depths between which the beams leave the water
    float last_start;
    float stop;       // m, depth beyond which they have no light
    uint next;        // index of the first node after all that lies below this one
    uint first_beam;  // of a finest node
    uint beams;       // how many; at most 8
};

struct ScatterSlab {
    float from, to;  // m of depth
    uint end;        // index after its last node
};

struct ScatterSegment {
    vec3 origin;     // m, world axes
    vec3 direction;  // unit, world axes
    float reach;     // m, where it ends
};

// What has been found on a segment, and where the walk through the nodes goes on.
struct ScatterSum {
    vec3 radiance;  // W/m^2/sr
    uint node;
    uint clusters, beams, intervals, peaks, cut, foci, dropped;  // as ScatterCounts
};

struct ScatterPush {
    vec3 axis_a;  // the sheet's axes in the world's
    vec3 axis_b;
    vec3 axis_depth;
    vec2 shift;       // m a m of way, by which all rays lean further from where they leave the water
    float largest;    // m, of all places at the last slab's first depth
    vec3 extinction;  // 1/m a channel
    vec3 scattered;   // W/m^3 or W/sr/m a channel that is scattered of a flux density of 1
    vec3 lobes[2];    // of the phase function, each x / (y + z sin^2(theta / 2))^(3/2), 1/sr
    float even;       // 1/sr, the phase function where it has neither lobes nor a table
    uint cells;       // of its table, evenly over sqrt(sin(theta / 2)); 0: it has none
    uint slabs;
    uint count;  // of segments
};

LAYOUT_END
#endif
