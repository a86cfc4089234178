#ifndef DAPPLE_DECAY_GLSL
#define DAPPLE_DECAY_GLSL
// e^-x for x >= 0, as src/methods/sliced_beams/exponential.h: the device's own exp may be coarse.
float decay(float x) {
    x = min(x, 87.0);  // e^-87 is the last normal number
    precise float whole = roundEven(x * 1.44269504);
    // ln 2 in two parts, the first short enough for exact products.
    precise float rest = (whole * 0.693359375 - x) - whole * 2.12194440e-4;
    precise float p = 1.0 / 5040.0;
    p = p * rest + 1.0 / 720.0;
    p = p * rest + 1.0 / 120.0;
    p = p * rest + 1.0 / 24.0;
    p = p * rest + 1.0 / 6.0;
    p = p * rest + 0.5;
    p = p * rest + 1.0;
    p = p * rest + 1.0;
    return p * intBitsToFloat((127 - int(whole)) << 23);
}
#endif
