#pragma once
#include <cfloat>

#include "metrics/lanes.h"

/// Elementary functions on vectors of floats, the same bits everywhere. Relative errors are at most 1e-6
/// where nothing else is said (tests/metrics/lane_math_test.cpp).
namespace dapple::metrics {

inline Floats minimum(Floats a, Floats b) {
    return _mm256_min_ps(a, b);
}

inline Floats maximum(Floats a, Floats b) {
    return _mm256_max_ps(a, b);
}

/// Held to [low, high]; a NaN becomes `low`.
inline Floats held(Floats x, float low, float high) {
    return minimum(maximum(x, all(low)), all(high));
}

inline Floats absolute(Floats x) {
    return _mm256_andnot_ps(all(-0.0f), x);
}

inline Floats square_root(Floats x) {
    return _mm256_sqrt_ps(x);
}

/// `yes` where a > b, else `no`.
inline Floats where_greater(Floats a, Floats b, Floats yes, Floats no) {
    return _mm256_blendv_ps(no, yes, _mm256_cmp_ps(a, b, _CMP_GT_OQ));
}

/// For positive normal numbers; the error is 1e-7 + 6e-8 |log2 x|, absolute.
inline Floats log2_of(Floats x) {
    // x = 2^e (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)); minimax polynomial of log2(1 + f) / f.
    const __m256i bits = _mm256_castps_si256(x);
    const __m256i e = _mm256_srai_epi32(_mm256_sub_epi32(bits, _mm256_set1_epi32(0x3f3504f3)), 23);
    const Floats f = _mm256_castsi256_ps(_mm256_sub_epi32(bits, _mm256_slli_epi32(e, 23))) - all(1);
    Floats p = all(-0.145989485f);
    p = fma(p, f, all(0.236745289f));
    p = fma(p, f, all(-0.249923727f));
    p = fma(p, f, all(0.286727448f));
    p = fma(p, f, all(-0.360103832f));
    p = fma(p, f, all(0.480938466f));
    p = fma(p, f, all(-0.721356648f));
    p = fma(p, f, all(1.44269479f));
    return fma(p, f, _mm256_cvtepi32_ps(e));
}

/// For x in [-126, 127]; what lies outside is held there.
inline Floats exp2_of(Floats x) {
    x = held(x, -126, 127);
    const Floats n = _mm256_round_ps(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    const Floats f = x - n;
    Floats p = all(0.000154780219f);
    p = fma(p, f, all(0.00134004317f));
    p = fma(p, f, all(0.00961799451f));
    p = fma(p, f, all(0.0555032722f));
    p = fma(p, f, all(0.240226515f));
    p = fma(p, f, all(0.693147207f));
    p = fma(p, f, all(1));
    const __m256i scale = _mm256_slli_epi32(_mm256_cvtps_epi32(n), 23);
    return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(p), scale));
}

/// x^y for x in [0, 1e4] and y in [0, 2.4]; 0^y is 0, of y = 0 too. Its error grows with |log2 x^y|: 1e-6 is
/// kept down to powers of 1e-4, 2e-6 down to 1e-8.
inline Floats power(Floats x, Floats y) {
    const Floats result = exp2_of(y * log2_of(maximum(x, all(FLT_MIN))));
    return where_greater(x, all(0), result, all(0));
}

/// For positive normal numbers.
inline Floats cube_root(Floats x) {
    // r tends to x^(-1/3): minus a third of the bits, which are a logarithm in steps, is off by less than 4
    // %; then two steps of third order by the residual h = 1 - x r^3.
    const Floats bits = _mm256_cvtepi32_ps(_mm256_castps_si256(x));
    Floats r = _mm256_castsi256_ps(_mm256_cvtps_epi32(fma(bits, all(-1.0f / 3), all(1419967116.0f))));
    for (int step = 0; step < 2; ++step) {
        const Floats h = fma(x * r, -(r * r), all(1));
        r = fma(r * h, fma(h, all(2.0f / 9), all(1.0f / 3)), r);
    }
    return x * r * r;
}

}  // namespace dapple::metrics
