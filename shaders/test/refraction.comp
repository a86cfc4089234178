#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Every function of optics/refraction.h, one input an invocation.
#include "optics/language.h"
#include "optics/refraction.h"
#include "test/refraction_case.h"

layout(local_size_x = 64) in;
layout(scalar, binding = 0) readonly buffer Inputs { RefractionInput inputs[]; };
layout(scalar, binding = 1) writeonly buffer Outputs { RefractionOutput outputs[]; };
layout(scalar, push_constant) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    RefractionInput given = inputs[i];
    RefractionOutput result;
    result.transmitted = refracted_direction(given.incident, given.normal, given.eta, result.refracted) ? 1u : 0u;
    result.reflected = reflected_direction(given.incident, given.normal);
    float cos_i = -dot(given.incident, given.normal);
    result.cos_t = transmitted_cosine(cos_i, given.eta);
    result.reflectance = fresnel_reflectance(cos_i, result.cos_t, given.eta);
    result.transmittance = fresnel_transmittance(cos_i, result.cos_t, given.eta);
    outputs[i] = result;
}
