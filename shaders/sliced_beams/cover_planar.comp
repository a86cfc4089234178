#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Irradiance of four receivers an invocation, by beams landed on their plane, in the order of the list.
#include "layout/coverage.h"
#include "sliced_beams/coverage.glsl"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Landed { LandedBeam landed[]; };
layout(scalar, binding = 1) readonly buffer Blocks { CoverageBlock blocks[]; };
layout(scalar, binding = 2) readonly buffer List { uint list[]; };
layout(scalar, binding = 3) readonly buffer Receivers { PlanarReceiver receivers[]; };
layout(scalar, binding = 4) writeonly buffer Irradiance { vec3 irradiance[]; };
layout(scalar, push_constant) uniform Push { CoveragePush push; };

vec3 power_at(PlanarReceiver r, LandedBeam beam) {
    precise vec3 dx = beam.x - r.center.x, dy = beam.y - r.center.y;
    precise vec3 x = r.to_x.x * dx + r.to_x.y * dy, y = r.to_y.x * dx + r.to_y.y * dy;
    return covered_share(x, y) * beam.power;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    CoverageBlock block = blocks[i];
    PlanarReceiver r0 = receivers[4 * i], r1 = receivers[4 * i + 1], r2 = receivers[4 * i + 2],
                   r3 = receivers[4 * i + 3];
    vec3 e0 = vec3(0.0), e1 = vec3(0.0), e2 = vec3(0.0), e3 = vec3(0.0);
    for (uint j = block.first; j < block.last; ++j) {
        uint first = 8 * list[j];
        for (uint k = 0; k < 8; ++k) {
            LandedBeam beam = landed[first + k];
            e0 += power_at(r0, beam);
            e1 += power_at(r1, beam);
            e2 += power_at(r2, beam);
            e3 += power_at(r3, beam);
        }
    }
    irradiance[4 * i] = r0.inverse_area * e0;
    irradiance[4 * i + 1] = r1.inverse_area * e1;
    irradiance[4 * i + 2] = r2.inverse_area * e2;
    irradiance[4 * i + 3] = r3.inverse_area * e3;
}
