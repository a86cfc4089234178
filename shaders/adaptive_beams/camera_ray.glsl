// What fragments know of their pixel: the camera's ray through it, in mesh space, and what it ends on.
// Length of the primary segment [m], way to the receiver [m], 0: none; whether they are in the water.
#ifndef FIRST_IMAGE
#define FIRST_IMAGE 5
#endif
layout(binding = FIRST_IMAGE) uniform sampler2D pixels;
layout(binding = FIRST_IMAGE + 1) uniform sampler2D normals;  // of receivers, world space
layout(binding = FIRST_IMAGE + 2) uniform sampler2D faces;    // their geometric normals, and the objects that they are on
layout(scalar, push_constant) uniform Push { BeamPush push; };

struct CameraRay {
    vec3 origin, direction;  // m, unit
    float segment;           // m; 0: none in the medium that the beams are in
    float receiver;          // m; the same
    ivec2 pixel;
};

CameraRay camera_ray() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 seen = texelFetch(pixels, pixel, 0);
    seen.xy = seen.z == push.in_water ? seen.xy : vec2(0.0);
    vec2 xy = vec2(pixel);
    vec3 direction = normalize(push.direction + xy.x * push.direction_u + xy.y * push.direction_v);
    return CameraRay(push.origin + xy.x * push.origin_u + xy.y * push.origin_v, direction, seen.x, seen.y, pixel);
}
