#pragma once
#include <immintrin.h>

#include <cstddef>
#include <cstring>

/// Vectors of the instruction set that the build fixes, by the compilers' vector extension: sums need lanes
/// of their own where the compiler may not reorder them. A fixed order of lanes gives the same bits
/// everywhere.
namespace dapple::metrics {

using Doubles = double __attribute__((vector_size(32)));
inline constexpr std::size_t kDoubleLanes = 4;

using Floats = __m256;
inline constexpr std::size_t kFloatLanes = 8;

inline Floats load(const float* values) {
    return _mm256_loadu_ps(values);
}

inline void store(float* values, Floats lanes) {
    _mm256_storeu_ps(values, lanes);
}

inline Floats all(float value) {
    return _mm256_set1_ps(value);
}

/// a b + c with one rounding, which the build never makes of a product and a sum by itself.
inline Floats fma(Floats a, Floats b, Floats c) {
    return _mm256_fmadd_ps(a, b, c);
}

inline Doubles load(const double* values) {
    Doubles lanes;
    std::memcpy(&lanes, values, sizeof lanes);
    return lanes;
}

inline void store(double* values, Doubles lanes) {
    std::memcpy(values, &lanes, sizeof lanes);
}

/// Four floats as doubles.
inline Doubles load_doubles(const float* values) {
    float __attribute__((vector_size(16))) lanes;
    std::memcpy(&lanes, values, sizeof lanes);
    return __builtin_convertvector(lanes, Doubles);
}

/// The first `count` of four floats, the others 0.
inline Doubles load_doubles(const float* values, std::size_t count) {
    if (count >= kDoubleLanes) return load_doubles(values);
    float padded[kDoubleLanes] = {};
    std::memcpy(padded, values, count * sizeof(float));
    return load_doubles(padded);
}

inline double sum(Doubles lanes) {
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

}  // namespace dapple::metrics
