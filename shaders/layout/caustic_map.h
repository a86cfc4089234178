// Structs of the light-view raster (light/caustic_map.vert) and of the beam rays (light/beam_rays.comp).
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

struct BeamRaysPush {
    vec2 anchor;       // m, map coordinates that texels are counted from
    vec2 column_step;  // m, from a texel to the next along columns
    vec2 row_step;     // m, and along rows
    int first_column;  // of the map, from the anchor
    int first_row;
    vec2 shear;  // as in CausticMapPush
    float inverse_height;
    float rest_height;  // m, height of the rest plane relative to the frame's origin
    vec3 light;         // sun: unit direction of travel; else position, m, relative to the frame's origin
    float eta;          // index of the medium that the light comes through over that of the other
    vec3 spot_axis;     // unit; of an area light its normal
    float cos_outer;    // cosine where a spot's light has fallen to nothing; -2: no spot
    vec3 axis;          // unit, axis of the beam mesh
    float cos_inner;    // cosine where it is full
    uint left;          // column of the map that this batch begins at
    uint top;           // and row
    uint columns;       // of this batch
    uint rows;          // of this batch
    uint sun;           // 1: parallel light
    uint reflection;    // 0: transmission
    uint emitter;       // 1: a part of an area light, which shines by the cosine to its normal
};

// One texel's ray.
struct BeamRay {
    vec3 origin;  // m, relative to the frame's origin, on the plane through it perpendicular to the mesh's
                  // axis
    float start;  // m, depth along the axis where the ray leaves the water
    vec3 slope;   // m a m of depth
    float flux;   // m^2 (sun) or sr, after Fresnel; negative: no ray
    float lost;   // what it would carry, had the mesh room for its direction
};

LAYOUT_END
#endif
