#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Lands the beams of clusters on the planes of tiles, a beam an invocation.
#include "layout/coverage.h"
#include "sliced_beams/landing.glsl"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Rays { CoverageRay rays[]; };
layout(scalar, binding = 1) readonly buffer Power { vec3 powers[]; };  // W of beams
layout(scalar, binding = 2) readonly buffer Triangles { uvec3 triangles[]; };
layout(scalar, binding = 3) readonly buffer Clusters { CoverageCluster clusters[]; };
layout(scalar, binding = 4) readonly buffer Frames { CoverageFrame frames[]; };
layout(scalar, binding = 5) writeonly buffer Landed { LandedBeam landed[]; };
layout(scalar, push_constant) uniform Push { CoveragePush push; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    uint beam = clusters[i / 8].beam[i % 8];
    bool present = beam != 0xffffffffu;
    uvec3 corner = triangles[present ? beam : 0];
    landed[i] = land_beam(rays[corner.x], rays[corner.y], rays[corner.z], present ? powers[beam] : vec3(0.0),
                          frames[clusters[i / 8].frame], push.absorption);
}
