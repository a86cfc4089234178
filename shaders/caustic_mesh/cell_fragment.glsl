// Mean of a cell's irradiance over each pixel's part of LAYERS layers at once, on the receiver of the pixel. Cells are
// laid over the picture as the camera sees them about that receiver, so that those which share an edge fit without a
// seam; host_cell_renderer.cpp does the same. `precise`, so that a layer has the same bits in any batch.
#extension GL_EXT_scalar_block_layout : require
#include "light/square_coverage.glsl"
#include "layout/mesh_cell.h"
layout(location = 0) flat in vec4 corner_0;
layout(location = 1) flat in vec4 corner_1;
layout(location = 2) flat in vec4 corner_2;
layout(location = 3) flat in vec4 corner_3;
layout(location = 4) flat in vec4 irradiance_0;
layout(location = 5) flat in vec4 irradiance_1;
layout(location = 6) flat in vec4 irradiance_2;
layout(location = 7) flat in vec4 irradiance_3;
layout(location = 8) flat in float disc;
layout(location = 0) out vec4 targets[LAYERS];
layout(scalar, push_constant) uniform Push { MeshPush push; };
// Receivers' positions, m, relative to the frame's origin, and 0 for none, 1 in the air, 2 in the water; and their
// normals.
layout(binding = 1) uniform sampler2D positions_0;
layout(binding = 2) uniform sampler2D normals_0;
#if LAYERS == 4
layout(binding = 3) uniform sampler2D positions_1;
layout(binding = 4) uniform sampler2D normals_1;
layout(binding = 5) uniform sampler2D positions_2;
layout(binding = 6) uniform sampler2D normals_2;
layout(binding = 7) uniform sampler2D positions_3;
layout(binding = 8) uniform sampler2D normals_3;
#endif

vec4 lit(sampler2D positions, sampler2D normals, vec4 filtered) {
    vec4 receiver = texelFetch(positions, ivec2(gl_FragCoord.xy), 0);
    if (receiver.w != irradiance_3.w + 1.0) return vec4(0.0);
    precise vec3 way_0 = corner_0.xyz - receiver.xyz;
    precise vec3 way_1 = corner_1.xyz - receiver.xyz;
    precise vec3 way_2 = corner_2.xyz - receiver.xyz;
    precise vec3 way_3 = corner_3.xyz - receiver.xyz;
    vec3 normal = vec3(corner_0.w, corner_1.w, corner_2.w);
    precise float off = 0.25 * dot(normal, way_0 + way_1 + way_2 + way_3);
    vec3 receiver_normal = texelFetch(normals, ivec2(gl_FragCoord.xy), 0).xyz;
    if (abs(off) > corner_3.w || dot(receiver_normal, normal) < kSmallestNormalCosine) return vec4(0.0);

    // Derivatives of the picture's coordinates by the place, at the receiver, over the filter's size.
    precise float w = dot(push.row_w.xyz, receiver.xyz) + push.row_w.w;
    precise float x = (dot(push.row_x.xyz, receiver.xyz) + push.row_x.w) / w;
    precise float y = (dot(push.row_y.xyz, receiver.xyz) + push.row_y.w) / w;
    precise vec3 to_x = (push.row_x.xyz - x * push.row_w.xyz) / w;
    precise vec3 to_y = (push.row_y.xyz - y * push.row_w.xyz) / w;
    // By rays that are moved across the beam, and with it along the plane.
    vec3 facing = vec3(irradiance_0.w, irradiance_1.w, irradiance_2.w);
    precise vec3 ray_x = to_x - normal * dot(to_x, facing);
    precise vec3 ray_y = to_y - normal * dot(to_y, facing);
    precise vec2 size = sqrt(filtered.zw * filtered.zw + disc * vec2(dot(ray_x, ray_x), dot(ray_y, ray_y)));
    to_x /= size.x;
    to_y /= size.y;
    precise vec2 shift = vec2(0.5) - filtered.xy / size;
    precise vec2 p_0 = vec2(dot(to_x, way_0), dot(to_y, way_0)) + shift;
    precise vec2 p_1 = vec2(dot(to_x, way_1), dot(to_y, way_1)) + shift;
    precise vec2 p_2 = vec2(dot(to_x, way_2), dot(to_y, way_2)) + shift;
    precise vec2 p_3 = vec2(dot(to_x, way_3), dot(to_y, way_3)) + shift;
    vec2 low = min(min(p_0, p_1), min(p_2, p_3)), high = max(max(p_0, p_1), max(p_2, p_3));
    if (any(greaterThanEqual(low, vec2(1.0))) || any(lessThanEqual(high, vec2(0.0)))) return vec4(0.0);

    precise vec3 diagonal = edge_moments(p_2, p_0);
    precise vec3 first = barycentric_integrals(p_0, p_1, p_2, edge_moments(p_0, p_1) + edge_moments(p_1, p_2) + diagonal);
    precise vec3 second = barycentric_integrals(p_0, p_2, p_3, edge_moments(p_2, p_3) + edge_moments(p_3, p_0) - diagonal);
    precise vec3 sum = (first.x + second.x) * irradiance_0.xyz + first.y * irradiance_1.xyz +
                       (first.z + second.y) * irradiance_2.xyz + second.z * irradiance_3.xyz;
    precise float cosine = max(0.0, dot(receiver_normal, facing));
    return vec4(cosine * sum, 0.0);
}
