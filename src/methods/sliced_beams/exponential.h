#pragma once
#include <cmath>

#include "methods/sliced_beams/lanes.h"

namespace dapple::methods::sliced_beams {

/// e^-x for x >= 0; in float within 2 ulp: 2^-n times Taylor's polynomial of the rest, |rest| <= ln(2) / 2.
inline Lanes<float> decay(Lanes<float> x) {
    x = lesser(x, splat(87.0f));  // e^-87 is the last normal number
    // Adding and taking away 1.5 * 2^23 rounds to a whole number, whose bits then stand in the mantissa.
    const Lanes<float> magic = splat(12582912.0f);
    const Lanes<float> shifted = x * 1.44269504f + magic;
    const Lanes<float> whole = shifted - magic;
    // ln 2 in two parts, the first short enough for exact products.
    const Lanes<float> rest = (whole * 0.693359375f - x) - whole * 2.12194440e-4f;
    Lanes<float> p = splat(1.0f / 5040);
    p = p * rest + 1.0f / 720;
    p = p * rest + 1.0f / 120;
    p = p * rest + 1.0f / 24;
    p = p * rest + 1.0f / 6;
    p = p * rest + 0.5f;
    p = p * rest + 1.0f;
    p = p * rest + 1.0f;
    const Mask<float> exponent = (127 - (reinterpret_cast<Mask<float>>(shifted) - 0x4b400000)) << 23;
    return p * reinterpret_cast<Lanes<float>>(exponent);
}

inline Lanes<double> decay(Lanes<double> x) {
    Lanes<double> result;
    for (int i = 0; i < kLanes<double>; ++i) result[i] = std::exp(-x[i]);
    return result;
}

}  // namespace dapple::methods::sliced_beams
