// One of the vertex shaders of beams: a corner of a beam's volume, with all that fragments need to know of the beam.
// BOUNDED: there are bounded media.
#extension GL_EXT_scalar_block_layout : require
#ifdef BOUNDED
#define FIRST_IMAGE 9
#else
#define FIRST_IMAGE 5
#endif
#define WAY out
#include "adaptive_beams/beam_varyings.glsl"
#include "layout/beam_volume.h"

layout(scalar, binding = 0) readonly buffer Beams { DrawnBeam beams[]; };
layout(scalar, binding = 1) readonly buffer Corners { vec3 corners[]; };  // x w and y w, pixels; w
layout(binding = FIRST_IMAGE) uniform sampler2D pixels;
layout(scalar, push_constant) uniform Push { BeamPush push; };

void main() {
    DrawnBeam beam = beams[gl_VertexIndex / 6];
    ray_0 = beam.ray[0];
    ray_1 = beam.ray[1];
    ray_2 = beam.ray[2];
    area_0 = beam.area[0];
    area_1 = beam.area[1];
    area_2 = beam.area[2];
    flux_start_0 = vec4(beam.flux[0], beam.start.x);
    flux_start_1 = vec4(beam.flux[1], beam.start.y);
    flux_start_2 = vec4(beam.flux[2], beam.start.z);
    end_bias = vec4(beam.end, beam.end_bias);
#ifdef BOUNDED
    beam_index = gl_VertexIndex / 6;
#endif
    flux_start_bias = vec4(beam.own_flux, beam.start_bias);
    listed_ends_on = ivec3(int(beam.first), int(beam.last), beam.ends_on);
    vec3 corner = corners[gl_VertexIndex];
    vec2 picture = vec2(textureSize(pixels, 0));
    // Depth is the same everywhere, so that nothing is clipped but what lies behind the camera.
    gl_Position = vec4(2.0 * (corner.xy + push.shift * corner.z) / picture - corner.z, 1e-5, corner.z);
}
