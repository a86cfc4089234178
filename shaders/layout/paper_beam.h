// A beam as Liktor and Dachsbacher 2011 draw it, in mesh space (shaders/adaptive_beams/paper*.glsl).
#ifndef DAPPLE_LAYOUT_PAPER_BEAM
#define DAPPLE_LAYOUT_PAPER_BEAM
#include "layout/types.h"
LAYOUT_BEGIN

// Sections are parallel to the caustic triangle, y metres from it along its normal.
struct PaperBeam {
    vec3 base[3];   // m, corners of the caustic triangle
    vec3 along[3];  // m a m of y
    vec3 normal;    // unit
    vec3 area;      // m^2, m, 1: the section's area is |area.x + area.y y + area.z y^2|
    vec3 flux;      // W a channel
    vec3 end;       // m, y at which the corners' rays end
    float bias;     // m of y before the triangle and beyond the end that belong to the beam
};

LAYOUT_END
#endif
