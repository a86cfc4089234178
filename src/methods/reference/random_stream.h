#pragma once
#include <cstdint>

#include "base/hash.h"

namespace dapple::reference {

/// Independent random numbers in [0, 1), one after the other, of one light ray.
struct RandomStream {
    std::uint64_t seed = 0;
    std::uint64_t frame = 0;
    std::uint64_t index = 0;  ///< of the ray
    std::uint32_t dimension = 0;

    double next() { return hash_uniform(seed, frame, index, dimension++); }
};

/// The index of a ray that comes of another, or of a numbered thing.
inline std::uint64_t branched(std::uint64_t index, std::uint64_t branch) {
    return static_cast<std::uint64_t>(hash_bits(index, branch, 0x6272616e, 0)) << 32 |
           hash_bits(index, branch, 0x6272616e, 1);
}

}  // namespace dapple::reference
