// Landing of beams: the arithmetic of src/methods/sliced_beams/landing.h, beam by beam.
#include "sliced_beams/decay.glsl"
#include "sliced_beams/quotient.glsl"

// Landing point of a ray in a frame; m of depth that it lies below the water, times the length of a way a m of depth.
// False where the ray does not meet the plane from its front.
bool land_ray(CoverageRay ray, CoverageFrame frame, out vec2 landed, out float way) {
    precise float a = ray.pass.x + frame.position.z * ray.pass.z - frame.position.x;
    precise float b = ray.pass.y + frame.position.z * ray.pass.w - frame.position.y;
    precise float facing = frame.normal.x * ray.pass.z + frame.normal.y * ray.pass.w + frame.normal.z;
    bool meets = facing < -1e-4;  // nearer to the plane's direction it lands too far off to say anything
    precise float offset = frame.normal.x * a + frame.normal.y * b;
    precise float further = quotient(offset, meets ? -facing : 1.0);
    precise float x = frame.along_x.x * a + frame.along_x.y * b +
                      further * (frame.along_x.x * ray.pass.z + frame.along_x.y * ray.pass.w + frame.along_x.z);
    precise float y = frame.along_y.x * a + frame.along_y.y * b +
                      further * (frame.along_y.x * ray.pass.z + frame.along_y.y * ray.pass.w + frame.along_y.z);
    precise float depth = frame.position.z + further - ray.start;
    precise float stretch = sqrt(1.0 + ray.pass.z * ray.pass.z + ray.pass.w * ray.pass.w);
    landed = vec2(x, y);
    way = depth * stretch;
    return meets;
}

// A beam with its absorption; without power where it does not land.
LandedBeam land_beam(CoverageRay r0, CoverageRay r1, CoverageRay r2, vec3 power, CoverageFrame frame,
                     vec3 absorption) {
    vec2 p0, p1, p2;
    float way0, way1, way2;
    bool lands0 = land_ray(r0, frame, p0, way0);
    bool lands1 = land_ray(r1, frame, p1, way1);
    bool lands2 = land_ray(r2, frame, p2, way2);
    LandedBeam beam;
    if (lands0 && lands1 && lands2 && power.x + power.y + power.z > 0.0) {
        precise float way = max((way0 + way1 + way2) / 3.0, 0.0);
        beam.x = vec3(p0.x, p1.x, p2.x);
        beam.y = vec3(p0.y, p1.y, p2.y);
        beam.power = power;
        if (absorption.x > 0.0) beam.power.x *= decay(absorption.x * way);
        if (absorption.y > 0.0) beam.power.y *= decay(absorption.y * way);
        if (absorption.z > 0.0) beam.power.z *= decay(absorption.z * way);
    } else {
        beam.x = beam.y = vec3(2.0);  // in reach of the square of no frame's own receiver
        beam.power = vec3(0.0);
    }
    return beam;
}
