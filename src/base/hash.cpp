#include "base/hash.h"

#include <xxhash.h>

#include <cstdio>

namespace dapple {

std::string content_hash(const void* data, std::size_t bytes) {
    const XXH128_hash_t hash = XXH3_128bits(data, bytes);
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

std::string content_hash(std::string_view text) {
    return content_hash(text.data(), text.size());
}

namespace {

// The finaliser of SplitMix64 (Steele, Lea & Flood 2014): a bijection of 64 bits that mixes well.
std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

}  // namespace

std::uint32_t hash_bits(std::uint64_t seed, std::uint64_t frame, std::uint64_t index,
                        std::uint32_t dimension) {
    const std::uint64_t key = mix(mix(mix(seed) ^ frame) ^ index) ^ dimension;
    return static_cast<std::uint32_t>(mix(key) >> 32);
}

double hash_uniform(std::uint64_t seed, std::uint64_t frame, std::uint64_t index, std::uint32_t dimension) {
    return hash_bits(seed, frame, index, dimension) * 0x1p-32;
}

}  // namespace dapple
