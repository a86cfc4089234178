// One of the vertex shaders of beams of the paper: a corner of a beam's volume, with what fragments need to know of the
// beam. BOUNDED: there are bounded media.
#extension GL_EXT_scalar_block_layout : require
#ifdef BOUNDED
#define FIRST_IMAGE 9
#else
#define FIRST_IMAGE 5
#endif
#define WAY out
#include "adaptive_beams/paper_varyings.glsl"
#include "layout/beam_volume.h"
#include "layout/paper_beam.h"

layout(scalar, binding = 0) readonly buffer Beams { PaperBeam beams[]; };
layout(scalar, binding = 1) readonly buffer Corners { vec3 corners[]; };  // x w and y w, pixels; w
layout(binding = FIRST_IMAGE) uniform sampler2D pixels;
layout(scalar, push_constant) uniform Push { BeamPush push; };

void main() {
    PaperBeam beam = beams[gl_VertexIndex / 6];
    base_end_0 = vec4(beam.base[0], beam.end.x);
    base_end_1 = vec4(beam.base[1], beam.end.y);
    base_end_2 = vec4(beam.base[2], beam.end.z);
    along_bias_0 = vec4(beam.along[0], beam.bias);
    along_1 = beam.along[1];
    along_2 = beam.along[2];
#ifdef BOUNDED
    beam_index = gl_VertexIndex / 6;
#endif
    beam_normal = beam.normal;
    area = beam.area;
    flux = beam.flux;
    vec3 corner = corners[gl_VertexIndex];
    vec2 picture = vec2(textureSize(pixels, 0));
    gl_Position = vec4(2.0 * (corner.xy + push.shift * corner.z) / picture - corner.z, 1e-5, corner.z);
}
