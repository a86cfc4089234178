#pragma once
#include <array>

#include "base/lanes.h"

namespace dapple::lanes {

/// Eight numbers of eight lanes each as eight lanes of eight numbers: structures of 32 bytes to and from one
/// register a member.
inline void transpose(std::array<Lanes<float>, 8>& rows) {
    __m256 r[8], t[8];
    for (std::size_t i = 0; i < 8; ++i) r[i] = reinterpret_cast<__m256>(rows[i]);
    for (std::size_t i = 0; i < 8; i += 2) {
        t[i] = _mm256_unpacklo_ps(r[i], r[i + 1]);
        t[i + 1] = _mm256_unpackhi_ps(r[i], r[i + 1]);
    }
    for (std::size_t i = 0; i < 8; i += 4) {
        r[i] = _mm256_shuffle_ps(t[i], t[i + 2], _MM_SHUFFLE(1, 0, 1, 0));
        r[i + 1] = _mm256_shuffle_ps(t[i], t[i + 2], _MM_SHUFFLE(3, 2, 3, 2));
        r[i + 2] = _mm256_shuffle_ps(t[i + 1], t[i + 3], _MM_SHUFFLE(1, 0, 1, 0));
        r[i + 3] = _mm256_shuffle_ps(t[i + 1], t[i + 3], _MM_SHUFFLE(3, 2, 3, 2));
    }
    for (std::size_t i = 0; i < 4; ++i) {
        rows[i] = reinterpret_cast<Lanes<float>>(_mm256_permute2f128_ps(r[i], r[i + 4], 0x20));
        rows[i + 4] = reinterpret_cast<Lanes<float>>(_mm256_permute2f128_ps(r[i], r[i + 4], 0x31));
    }
}

}  // namespace dapple::lanes
