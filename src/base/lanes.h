#pragma once
#include <immintrin.h>

#include <cmath>
#include <cstdint>

/// Vectors of the instruction set that the build fixes, by the compilers' vector extension. A fixed order of
/// lanes gives the same bits everywhere.
namespace dapple::lanes {

/// As many numbers as one register holds: 8 floats or 4 doubles.
template <class Real>
struct LanesOf;
template <>
struct LanesOf<float> {
    using Numbers __attribute__((vector_size(32))) = float;
    using Mask __attribute__((vector_size(32))) = std::int32_t;  ///< -1 or 0 a lane
};
template <>
struct LanesOf<double> {
    using Numbers __attribute__((vector_size(32))) = double;
    using Mask __attribute__((vector_size(32))) = std::int64_t;
};
template <class Real>
using Lanes = typename LanesOf<Real>::Numbers;
template <class Real>
using Mask = typename LanesOf<Real>::Mask;

template <class Real>
constexpr int kLanes = 32 / static_cast<int>(sizeof(Real));

template <class Real>
inline Lanes<Real> splat(Real value) {
    return value - Lanes<Real>{};
}
template <class Numbers>
inline Numbers lesser(Numbers x, Numbers y) {
    return x < y ? x : y;
}
template <class Numbers>
inline Numbers greater(Numbers x, Numbers y) {
    return x > y ? x : y;
}
/// x y + z, rounded once.
inline Lanes<float> multiply_add(Lanes<float> x, Lanes<float> y, Lanes<float> z) {
    return reinterpret_cast<Lanes<float>>(_mm256_fmadd_ps(
        reinterpret_cast<__m256>(x), reinterpret_cast<__m256>(y), reinterpret_cast<__m256>(z)));
}
inline Lanes<double> multiply_add(Lanes<double> x, Lanes<double> y, Lanes<double> z) {
    return reinterpret_cast<Lanes<double>>(_mm256_fmadd_pd(
        reinterpret_cast<__m256d>(x), reinterpret_cast<__m256d>(y), reinterpret_cast<__m256d>(z)));
}
template <class Real>
inline Lanes<Real> square_root(Lanes<Real> x) {
    if constexpr (sizeof(Real) == 4)
        return reinterpret_cast<Lanes<Real>>(_mm256_sqrt_ps(reinterpret_cast<__m256>(x)));
    else
        return reinterpret_cast<Lanes<Real>>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(x)));
}
/// x^(-1/2). Not by the instruction that estimates it, of which every maker of processors has bits of its
/// own.
inline Lanes<float> inverse_root(Lanes<float> x) {
    return 1.0f / square_root<float>(x);
}
inline Lanes<double> inverse_root(Lanes<double> x) {
    return 1.0 / square_root<double>(x);
}
inline Lanes<float> magnitude(Lanes<float> x) {
    return reinterpret_cast<Lanes<float>>(reinterpret_cast<Mask<float>>(x) & 0x7fffffff);
}
inline Lanes<double> magnitude(Lanes<double> x) {
    return reinterpret_cast<Lanes<double>>(reinterpret_cast<Mask<double>>(x) & 0x7fffffffffffffff);
}
/// To the nearest whole number, halves to the even one.
inline Lanes<float> rounded(Lanes<float> x) {
    return reinterpret_cast<Lanes<float>>(
        _mm256_round_ps(reinterpret_cast<__m256>(x), _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
/// One bit a lane, the first lane lowest. For any mask: compilers differ in the type that a comparison has.
template <class AnyMask>
inline unsigned bits(AnyMask m) {
    static_assert(sizeof(AnyMask) == 32);
    if constexpr (sizeof(m[0]) == 4)
        return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(m)));
    else
        return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(m)));
}
template <class AnyMask>
inline bool any(AnyMask m) {
    return bits(m) != 0;
}
/// Sum of the lanes, always in the same order.
inline float sum(Lanes<float> x) {
    return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}
inline double sum(Lanes<double> x) {
    return (x[0] + x[2]) + (x[1] + x[3]);
}

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

}  // namespace dapple::lanes
