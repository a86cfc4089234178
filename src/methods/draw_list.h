#pragma once
#include <immintrin.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/large_vector.h"
#include "base/parallel.h"

namespace dapple::methods {

/// Copies to where nobody will look soon, past the caches: these need not fetch first what is written over.
template <class Primitive>
void stream(std::span<const Primitive> from, Primitive* to) {
    if (sizeof(Primitive) % sizeof(__m256) != 0 ||
        reinterpret_cast<std::uintptr_t>(to) % sizeof(__m256) != 0) {
        std::copy(from.begin(), from.end(), to);
        return;
    }
    constexpr std::size_t kFloats = sizeof(__m256) / sizeof(float);
    const auto* source = reinterpret_cast<const float*>(from.data());
    auto* target = reinterpret_cast<float*>(to);
    for (std::size_t i = 0; i < from.size_bytes() / sizeof(float); i += kFloats)
        _mm256_stream_ps(target + i, _mm256_loadu_ps(source + i));
    _mm_sfence();
}

/// What is drawn into pictures, in pieces of memory, of which room() is all.
template <class Primitive, class Memory>
class DrawList {
public:
    struct Chunk {
        Memory memory;
        std::size_t count;  ///< primitives that are used, of its room
    };

    /// `most`: primitives in a piece.
    explicit DrawList(std::size_t most) : most_(std::max<std::size_t>(1, most)) {}

    /// Keeps the memory that was used: what is there already costs nothing to write to.
    void clear() {
        std::erase_if(chunks_, [](const Chunk& chunk) { return chunk.count == 0; });
        for (Chunk& chunk : chunks_) chunk.count = 0;
        size_ = used_ = 0;
    }
    std::size_t size() const { return size_; }
    /// In order; those at the end may be empty.
    const std::vector<Chunk>& chunks() const { return chunks_; }

    /// Appends the bands one after another. `make(room)`: a piece of memory.
    template <class Band, class Make>
    void add(const std::vector<Band>& bands, const Make& make) {
        struct Part {
            std::span<const Primitive> from;
            Primitive* to;
        };
        std::vector<Part> parts;
        std::size_t left = 0;  // of these bands
        for (const Band& band : bands) left += band.size();
        for (const Band& band : bands) {
            std::span<const Primitive> rest = band;
            while (!rest.empty()) {
                while (used_ < chunks_.size() && chunks_[used_].count == chunks_[used_].memory.room().size())
                    ++used_;
                // Pieces grow to the largest that there is: a draw each.
                if (used_ == chunks_.size())
                    chunks_.push_back({make(std::min(most_, std::max(left, size_))), 0});
                Chunk& chunk = chunks_[used_];
                const std::span<Primitive> room = chunk.memory.room().subspan(chunk.count);
                const std::size_t count = std::min(rest.size(), room.size());
                parts.push_back({rest.first(count), room.data()});
                chunk.count += count;
                size_ += count;
                left -= count;
                rest = rest.subspan(count);
            }
        }
        parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) stream(parts[i].from, parts[i].to);
        });
    }

private:
    std::size_t most_, size_ = 0, used_ = 0;  // used_: the first chunk that may have room
    std::vector<Chunk> chunks_;
};

}  // namespace dapple::methods
