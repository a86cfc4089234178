// Evaluates a splat's kernel at the receiver of the pixel, for LAYERS layers at once; host_splat_renderer.cpp does the
// same. `precise`, so that a layer has the same bits in any batch.
// LAYERS: 1 or 4. BOXES: kernels are boxes, else tents. DEPTH_TEST: as the paper tells receivers.
#extension GL_EXT_scalar_block_layout : require
#include "layout/splat.h"
layout(location = 0) flat in vec4 position_tolerance;
layout(location = 1) flat in vec4 axis_a;
layout(location = 2) flat in vec4 axis_b;
layout(location = 3) flat in vec4 irradiance;
layout(location = 4) flat in vec3 normal;
layout(location = 5) flat in vec3 facing;
layout(location = 0) out vec4 targets[LAYERS];
// Receiver's position, m, relative to the frame's origin, and a code: 0 for none, else bit 31 the medium, bits 14 to
// 27 and 0 to 13 the octahedral normal (splat_renderer.cpp writes it).
layout(binding = 1) uniform sampler2D receivers_0;
#if LAYERS == 4
layout(binding = 2) uniform sampler2D receivers_1;
layout(binding = 3) uniform sampler2D receivers_2;
layout(binding = 4) uniform sampler2D receivers_3;
#endif

vec3 decoded_normal(uint code) {
    vec2 f = vec2((uvec2(code >> 14, code) & 0x3fffu)) / 8191.0 - 1.0;
    vec3 n = vec3(f.x, 1.0 - abs(f.x) - abs(f.y), f.y);
    float fold = max(-n.y, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.z += n.z >= 0.0 ? -fold : fold;
    return normalize(n);
}

#ifdef BOXES
// A box of half-width 1 - box, convolved with a box of half-width `box`: support [-1, 1], integral 1.
float profile(float x, float box) {
    float core = 1.0 - box;
    return min(1.0 - abs(x), 2.0 * min(core, box)) / (4.0 * core * box);
}
#else
// Integral from -infinity of the tent max(0, 1 - |x|).
float tent_integral(float x) {
    x = clamp(x, -1.0, 1.0);
    return 0.5 + x - 0.5 * x * abs(x);
}

// A tent of half-width 1 - box, convolved with a box of half-width `box`: support [-1, 1], integral 1.
float profile(float x, float box) {
    if (box == 0.0) return max(0.0, 1.0 - abs(x));
    float scale = 1.0 / (1.0 - box);
    return (tent_integral((x + box) * scale) - tent_integral((x - box) * scale)) / (2.0 * box);
}
#endif

#ifdef DEPTH_TEST
layout(scalar, push_constant) uniform Push { SplatPush push; };

// Kougianos and Moustakas 2021, section 3.2: the splat is a quad on its plane, drawn where it is not behind what the
// camera sees, less a bias. Moves `offset` from the receiver to the quad along the camera's ray.
bool is_lit(vec3 receiver, uint code, inout vec3 offset) {
    precise vec3 away = push.perspective != 0u ? normalize(receiver - push.camera) : -push.camera;
    precise float facing_camera = dot(normal, away);
    if (facing_camera > -kEdgeOn) return false;
    precise float behind = -dot(normal, offset) / facing_camera;
    offset += behind * away;
    return behind <= kDepthBias;
}
bool faces(vec3 receiver_normal) { return true; }
#else
// The receiver lies in the splat's medium, on its plane, and leans as that does.
bool is_lit(vec3 receiver, uint code, inout vec3 offset) {
    return float(code >> 31) == irradiance.w && abs(dot(normal, offset)) <= position_tolerance.w;
}
bool faces(vec3 receiver_normal) { return dot(receiver_normal, normal) >= kSmallestNormalCosine; }
#endif

vec4 lit(sampler2D receiver_image) {
    vec4 receiver = texelFetch(receiver_image, ivec2(gl_FragCoord.xy), 0);
    uint code = floatBitsToUint(receiver.w);
    precise vec3 offset = receiver.xyz - position_tolerance.xyz;
    bool on_splat = is_lit(receiver.xyz, code, offset);
    precise float a = dot(axis_a.xyz, offset);
    precise float b = dot(axis_b.xyz, offset);
    if (code == 0u || max(abs(a), abs(b)) >= 1.0 || !on_splat) return vec4(0.0);
    vec3 receiver_normal = decoded_normal(code);
    if (!faces(receiver_normal)) return vec4(0.0);
    precise float weight = profile(a, axis_a.w) * profile(b, axis_b.w) * max(0.0, dot(receiver_normal, facing));
    return vec4(weight * irradiance.xyz, 0.0);
}
