#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace dapple {

/// 128-bit content hash (XXH3) as 32 hexadecimal digits. Names content; it is no protection against forgery.
std::string content_hash(const void* data, std::size_t bytes);
std::string content_hash(std::string_view text);

/// A uniform 32-bit value that is a pure function of its arguments (counter-based, no state).
std::uint32_t hash_bits(std::uint64_t seed, std::uint64_t frame, std::uint64_t index,
                        std::uint32_t dimension);

/// The same as a number in [0, 1).
double hash_uniform(std::uint64_t seed, std::uint64_t frame, std::uint64_t index, std::uint32_t dimension);

}  // namespace dapple
