// Struct of the light-view raster (light/caustic_map.vert).
// Map coordinates are metres on the rest plane y = 0, (x, z), relative to the frame's origin. The light
// projects a water point (x, height, z) onto ((x, z) - shear * height) / (1 - inverse_height * height).
#ifndef DAPPLE_LAYOUT_CAUSTIC_MAP
#define DAPPLE_LAYOUT_CAUSTIC_MAP
#include "layout/types.h"
LAYOUT_BEGIN

struct CausticMapPush {
    vec2 shear;            // m a m of height
    float inverse_height;  // 1/m: one over the light's height above the rest plane; 0 for a sun
    vec4 clip_scale;       // 1/m: clip from map coordinates, columns of a 2 x 2 matrix
    vec2 clip_offset;      // clip space
    vec2 depth;            // clip z = depth.x + depth.y * height (1/m); grows along the light
};

LAYOUT_END
#endif
