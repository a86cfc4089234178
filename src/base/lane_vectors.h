#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

#include "base/lanes.h"

/// Vectors of eight places or directions at once, a lane each.
namespace dapple::lanes {

using Floats = Lanes<float>;
using Flags = Mask<float>;  ///< -1 or 0 a lane

struct Vectors2 {
    Floats x{}, y{};
};
struct Vectors3 {
    Floats x{}, y{}, z{};
};

inline Vectors2 operator+(Vectors2 a, Vectors2 b) {
    return {a.x + b.x, a.y + b.y};
}
inline Vectors2 operator-(Vectors2 a, Vectors2 b) {
    return {a.x - b.x, a.y - b.y};
}
inline Vectors2 operator-(Vectors2 a) {
    return {-a.x, -a.y};
}
inline Vectors2 operator*(Floats a, Vectors2 b) {
    return {a * b.x, a * b.y};
}
inline Floats dot(Vectors2 a, Vectors2 b) {
    return a.x * b.x + a.y * b.y;
}
inline Floats cross(Vectors2 a, Vectors2 b) {
    return a.x * b.y - a.y * b.x;
}

inline Vectors3 operator+(Vectors3 a, Vectors3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vectors3 operator-(Vectors3 a, Vectors3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vectors3 operator-(Vectors3 a) {
    return {-a.x, -a.y, -a.z};
}
inline Vectors3 operator*(Floats a, Vectors3 b) {
    return {a * b.x, a * b.y, a * b.z};
}
inline Floats dot(Vectors3 a, Vectors3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Floats dot(glm::vec3 a, Vectors3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vectors3 cross(Vectors3 a, Vectors3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Floats all(float value) {
    return splat(value);
}
inline Vectors3 all(glm::vec3 value) {
    return {all(value.x), all(value.y), all(value.z)};
}
inline Flags all(bool value) {
    return Flags{} - (value ? 1 : 0);
}
/// The first `count` of eight.
inline Flags first_of(std::size_t count) {
    return Flags{0, 1, 2, 3, 4, 5, 6, 7} < static_cast<std::int32_t>(count);
}

inline Vectors2 choose(Flags which, Vectors2 yes, Vectors2 no) {
    return {which ? yes.x : no.x, which ? yes.y : no.y};
}
inline Vectors3 choose(Flags which, Vectors3 yes, Vectors3 no) {
    return {which ? yes.x : no.x, which ? yes.y : no.y, which ? yes.z : no.z};
}

inline Vectors3 normalized(Vectors3 v) {
    return inverse_root(dot(v, v)) * v;
}
inline Flags finite(Floats x) {
    return magnitude(x) < std::numeric_limits<float>::infinity();
}

inline glm::vec3 lane(Vectors3 v, std::size_t k) {
    return {v.x[k], v.y[k], v.z[k]};
}
inline void set_lane(Vectors3& v, std::size_t k, glm::vec3 value) {
    v.x[k] = value.x;
    v.y[k] = value.y;
    v.z[k] = value.z;
}

// Eight that follow one another in memory, or two times four.
inline Floats load(const float* eight) {
    return reinterpret_cast<Floats>(_mm256_loadu_ps(eight));
}
inline Floats load(const float* four, const float* other_four) {
    return reinterpret_cast<Floats>(_mm256_loadu2_m128(other_four, four));
}
inline void store(float* eight, Floats value) {
    _mm256_storeu_ps(eight, reinterpret_cast<__m256>(value));
}
inline void store(float* four, float* other_four, Floats value) {
    _mm256_storeu2_m128(other_four, four, reinterpret_cast<__m256>(value));
}
inline Vectors3 load(const glm::vec3* four, const glm::vec3* other_four) {
    const float *low = &four->x, *high = &other_four->x;
    // Of each half of four vectors: x y z x, y z x y, z x y z.
    const __m256 a = _mm256_loadu2_m128(high, low), b = _mm256_loadu2_m128(high + 4, low + 4),
                 c = _mm256_loadu2_m128(high + 8, low + 8);
    const __m256 xy = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    const __m256 yz = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
    return {reinterpret_cast<Floats>(_mm256_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0))),
            reinterpret_cast<Floats>(_mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0))),
            reinterpret_cast<Floats>(_mm256_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1)))};
}
inline Vectors3 load(const glm::vec3* eight) {
    return load(eight, eight + 4);
}
inline void store(glm::vec3* four, glm::vec3* other_four, Vectors3 value) {
    float *low = &four->x, *high = &other_four->x;
    const auto x = reinterpret_cast<__m256>(value.x), y = reinterpret_cast<__m256>(value.y),
               z = reinterpret_cast<__m256>(value.z);
    const __m256 xy = _mm256_shuffle_ps(x, y, _MM_SHUFFLE(2, 0, 2, 0));
    const __m256 yz = _mm256_shuffle_ps(y, z, _MM_SHUFFLE(3, 1, 3, 1));
    const __m256 zx = _mm256_shuffle_ps(z, x, _MM_SHUFFLE(3, 1, 2, 0));
    _mm256_storeu2_m128(high, low, _mm256_shuffle_ps(xy, zx, _MM_SHUFFLE(2, 0, 2, 0)));
    _mm256_storeu2_m128(high + 4, low + 4, _mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)));
    _mm256_storeu2_m128(high + 8, low + 8, _mm256_shuffle_ps(zx, yz, _MM_SHUFFLE(3, 1, 3, 1)));
}
inline void store(glm::vec3* eight, Vectors3 value) {
    store(eight, eight + 4, value);
}
/// Of bytes that are 0 or not.
inline Flags load(const std::uint8_t* eight) {
    const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(eight));
    return reinterpret_cast<Flags>(_mm256_cvtepu8_epi32(bytes)) != 0;
}

}  // namespace dapple::lanes
