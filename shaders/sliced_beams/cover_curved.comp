#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Irradiance of four receivers an invocation, each on a plane of its own, in the order of the list.
#include "layout/coverage.h"
#include "sliced_beams/coverage.glsl"
#include "sliced_beams/landing.glsl"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Rays { CoverageRay rays[]; };
layout(scalar, binding = 1) readonly buffer Power { vec3 powers[]; };  // W of beams
layout(scalar, binding = 2) readonly buffer Triangles { uvec3 triangles[]; };
layout(scalar, binding = 3) readonly buffer Clusters { CoverageCluster clusters[]; };
layout(scalar, binding = 4) readonly buffer Blocks { CoverageBlock blocks[]; };
layout(scalar, binding = 5) readonly buffer List { uint list[]; };
layout(scalar, binding = 6) readonly buffer Receivers { CurvedReceiver receivers[]; };
layout(scalar, binding = 7) writeonly buffer Irradiance { vec3 irradiance[]; };
layout(scalar, push_constant) uniform Push { CoveragePush push; };

struct Beam {
    CoverageRay r0, r1, r2;
    vec3 power;
};
Beam beam_of(uint index) {
    bool present = index != 0xffffffffu;
    uvec3 corner = triangles[present ? index : 0];
    Beam beam;
    beam.r0 = rays[corner.x];
    beam.r1 = rays[corner.y];
    beam.r2 = rays[corner.z];
    beam.power = present ? powers[index] : vec3(0.0);
    return beam;
}
LandedBeam land_at(CurvedReceiver r, Beam beam) {
    return land_beam(beam.r0, beam.r1, beam.r2, beam.power, r.frame, push.absorption);
}
vec3 power_at(CurvedReceiver r, Beam beam) {
    LandedBeam landed = land_at(r, beam);
    return covered_share(landed.x, landed.y) * landed.power;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    CoverageBlock block = blocks[i];
    CurvedReceiver s0 = receivers[4 * i], s1 = receivers[4 * i + 1], s2 = receivers[4 * i + 2],
                   s3 = receivers[4 * i + 3];
    vec3 e0 = vec3(0.0), e1 = vec3(0.0), e2 = vec3(0.0), e3 = vec3(0.0);
    for (uint j = block.first; j < block.last; ++j) {
        for (uint k = 0; k < 8; ++k) {
            Beam beam = beam_of(clusters[list[j]].beam[k]);
            e0 += power_at(s0, beam);
            e1 += power_at(s1, beam);
            e2 += power_at(s2, beam);
            e3 += power_at(s3, beam);
        }
    }
    irradiance[4 * i] = s0.inverse_area * e0;
    irradiance[4 * i + 1] = s1.inverse_area * e1;
    irradiance[4 * i + 2] = s2.inverse_area * e2;
    irradiance[4 * i + 3] = s3.inverse_area * e3;
}
