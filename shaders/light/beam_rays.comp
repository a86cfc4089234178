#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Refracts or reflects the light at each texel of the caustic map and writes the ray of the beam mesh.
#include "layout/caustic_map.h"
#include "optics/language.h"
#include "optics/refraction.h"
#include "optics/spot_light.h"

layout(local_size_x = 16, local_size_y = 4) in;
layout(scalar, binding = 0) writeonly buffer Rays { BeamRay rays[]; };
layout(binding = 1) uniform sampler2D map;  // height above the rest plane (m) and normal; normal 0: no water
layout(scalar, push_constant) uniform Push { BeamRaysPush push; };

const float kSmallestAxisCosine = 0.1;  // of light::BeamMesh::axis
const float kNoRay = -1.0;              // flux of a texel without water or without a transmitted ray

void main() {
    if (gl_GlobalInvocationID.x >= push.columns || gl_GlobalInvocationID.y >= push.rows) return;
    uvec2 at = gl_GlobalInvocationID.xy + uvec2(push.left, push.top);
    vec4 texel = texelFetch(map, ivec2(at), 0);
    bool water = dot(texel.yzw, texel.yzw) > 0.0;
    // Without water the rest plane goes on, so that every ray is finite.
    float height = water ? texel.x : 0.0;
    vec3 normal = water ? normalize(texel.yzw) : vec3(0.0, 1.0, 0.0);

    vec2 place = vec2(ivec2(at) + ivec2(push.first_column, push.first_row)) + 0.5;
    vec2 center = push.anchor + push.column_step * place.x + push.row_step * place.y;
    vec2 foot = center * (1.0 - push.inverse_height * height) + push.shear * height;
    vec3 point = vec3(foot.x, height + push.rest_height, foot.y);

    // Light through the texel of the rest plane: area across the beam (sun), or solid angle of the texel.
    vec3 incident = push.light;
    float power = abs(push.column_step.x * push.row_step.y - push.column_step.y * push.row_step.x);
    if (push.sun != 0u) {
        power *= abs(incident.y);
    } else {
        incident = normalize(point - push.light);
        vec3 way = vec3(center.x, push.rest_height, center.y) - push.light;
        float square = dot(way, way);
        power *= abs(way.y) / (square * sqrt(square));
        if (push.cos_outer > -2.0)
            power *= spot_light_falloff(dot(incident, push.spot_axis), push.cos_outer, push.cos_inner);
        if (push.emitter != 0u) power *= max(0.0, dot(incident, push.spot_axis));
    }

    if (push.inverse_height < 0.0) normal = -normal;  // towards a light under water
    float cos_i = -dot(incident, normal);
    bool facing = cos_i > 0.0;
    cos_i = clamp(cos_i, 0.0, 1.0);
    float cos_t = transmitted_cosine(cos_i, push.eta);
    vec3 direction;
    bool leaves = true;
    float share;
    if (push.reflection != 0u) {
        direction = reflected_direction(incident, normal);
        share = fresnel_reflectance(cos_i, cos_t, push.eta);
    } else {
        leaves = refracted_direction(incident, normal, push.eta, direction);
        share = fresnel_transmittance(cos_i, cos_t, push.eta);
    }

    BeamRay ray;
    float along = dot(direction, push.axis);
    bool carried = water && facing && leaves;
    ray.flux = carried ? power * share : kNoRay;
    ray.lost = 0.0;
    if (!leaves || along <= kSmallestAxisCosine) {
        if (carried) ray.lost = ray.flux;
        ray.flux = kNoRay;
        direction = push.axis;
        along = 1.0;
    }
    ray.slope = direction / along;
    ray.start = dot(point, push.axis);
    ray.origin = point - ray.start * ray.slope;
    rays[gl_GlobalInvocationID.y * push.columns + gl_GlobalInvocationID.x] = ray;
}
