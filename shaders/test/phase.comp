#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Every function of optics/phase.h, one input an invocation.
#include "optics/language.h"
#include "optics/phase.h"
#include "test/phase_case.h"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Inputs { PhaseInput inputs[]; };
layout(scalar, binding = 1) writeonly buffer Outputs { PhaseOutput outputs[]; };
layout(scalar, push_constant) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    PhaseInput given = inputs[i];
    outputs[i].isotropic = isotropic_phase();
    outputs[i].henyey_greenstein = henyey_greenstein_phase(given.cosine, given.g);
    outputs[i].two_lobe = two_lobe_phase(given.cosine, given.g, -0.4, 0.7);
    outputs[i].fournier_forand = fournier_forand_phase(given.cosine, given.index, given.slope);
    outputs[i].within = fournier_forand_within(0.5 - 0.5 * given.cosine, given.index, given.slope);
}
