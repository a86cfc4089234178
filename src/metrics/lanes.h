#pragma once
#include <cstddef>
#include <cstring>

/// Vectors of the instruction set that the build fixes, by the compilers' vector extension: sums need lanes
/// of their own where the compiler may not reorder them. A fixed order of lanes gives the same bits
/// everywhere.
namespace dapple::metrics {

using Doubles = double __attribute__((vector_size(32)));
inline constexpr std::size_t kDoubleLanes = 4;

using Floats = float __attribute__((vector_size(32)));
inline constexpr std::size_t kFloatLanes = 8;

inline Floats load(const float* values) {
    Floats lanes;
    std::memcpy(&lanes, values, sizeof lanes);
    return lanes;
}

inline void store(float* values, Floats lanes) {
    std::memcpy(values, &lanes, sizeof lanes);
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
