#pragma once
#include <immintrin.h>

#include <cstdint>

namespace dapple::methods::sliced_beams {

/// Beams are worked on eight at a time.
constexpr int kClusterBeams = 8;

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
constexpr int kChunks = kClusterBeams / kLanes<Real>;

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
/// x^(-1/2); in float within 3 ulp: an estimate of 12 bits and a step of Newton's.
inline Lanes<float> inverse_root(Lanes<float> x) {
    const auto estimate = reinterpret_cast<Lanes<float>>(_mm256_rsqrt_ps(reinterpret_cast<__m256>(x)));
    return estimate * (1.5f - (0.5f * x) * estimate * estimate);
}
inline Lanes<double> inverse_root(Lanes<double> x) {
    return 1.0 / reinterpret_cast<Lanes<double>>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(x)));
}
inline Lanes<float> magnitude(Lanes<float> x) {
    return reinterpret_cast<Lanes<float>>(reinterpret_cast<Mask<float>>(x) & 0x7fffffff);
}
inline Lanes<double> magnitude(Lanes<double> x) {
    return reinterpret_cast<Lanes<double>>(reinterpret_cast<Mask<double>>(x) & 0x7fffffffffffffff);
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

}  // namespace dapple::methods::sliced_beams
