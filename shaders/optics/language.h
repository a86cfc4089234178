// What lets one text be GLSL and C++ (see src/optics/optics.h, which includes the physics headers twice: once
// with real = float in namespace f32, once with real = double in namespace f64).
// Rules: functions are marked FN; results through OUT(T) or INOUT(T); every literal is written real(0.5),
// also inside min, max and clamp; no swizzles but .x .y .z .w; no constructor calls of structs; no array
// parameters.
#ifdef __cplusplus
#define FN inline
#define OUT(T) T&
#define INOUT(T) T&
#else
#define FN
#define OUT(T) out T
#define INOUT(T) inout T
#ifndef DAPPLE_REAL_DEFINED
#define DAPPLE_REAL_DEFINED
#define real float
#define real2 vec2
#define real3 vec3
#endif
#endif
