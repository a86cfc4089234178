#pragma once
#include <immintrin.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/lanes.h"
#include "base/large_vector.h"
#include "base/parallel.h"
#include "layout/splat.h"

namespace dapple::methods {

/// Copies to where nobody will look soon, past the caches: these need not fetch first what is written over.
inline void stream(std::span<const layout::Splat> from, layout::Splat* to) {
    const auto* source = reinterpret_cast<const float*>(from.data());
    auto* target = reinterpret_cast<float*>(to);
    if (reinterpret_cast<std::uintptr_t>(to) % sizeof(__m256) != 0) {
        std::copy(from.begin(), from.end(), to);
        return;
    }
    for (std::size_t i = 0; i < from.size_bytes() / sizeof(float); i += lanes::kLanes<float>)
        _mm256_stream_ps(target + i, _mm256_loadu_ps(source + i));
    _mm_sfence();
}

/// Splats in pieces of memory, which are made with a room of so many and whose splats() is all of it.
template <class Memory>
class SplatList {
public:
    struct Chunk {
        Memory memory;
        std::size_t count;  ///< splats that are used, of its room
    };

    /// `most`: splats in a piece.
    explicit SplatList(std::size_t most) : most_(std::max<std::size_t>(1, most)) {}

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
    template <class Make>
    void add(const std::vector<LargeVector<layout::Splat>>& bands, const Make& make) {
        struct Piece {
            std::span<const layout::Splat> from;
            layout::Splat* to;
        };
        std::vector<Piece> pieces;
        std::size_t left = 0;  // of these bands
        for (const LargeVector<layout::Splat>& band : bands) left += band.size();
        for (const LargeVector<layout::Splat>& band : bands) {
            std::span<const layout::Splat> rest = band;
            while (!rest.empty()) {
                while (used_ < chunks_.size() &&
                       chunks_[used_].count == chunks_[used_].memory.splats().size())
                    ++used_;
                // Pieces grow to the largest that there is: a draw each.
                if (used_ == chunks_.size())
                    chunks_.push_back({make(std::min(most_, std::max(left, size_))), 0});
                Chunk& chunk = chunks_[used_];
                const std::span<layout::Splat> room = chunk.memory.splats().subspan(chunk.count);
                const std::size_t count = std::min(rest.size(), room.size());
                pieces.push_back({rest.first(count), room.data()});
                chunk.count += count;
                size_ += count;
                left -= count;
                rest = rest.subspan(count);
            }
        }
        parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) stream(pieces[i].from, pieces[i].to);
        });
    }

private:
    std::size_t most_, size_ = 0, used_ = 0;  // used_: the first chunk that may have room
    std::vector<Chunk> chunks_;
};

}  // namespace dapple::methods
