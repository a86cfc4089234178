#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dapple {

/// Frame numbers in the order in which they are wanted, each once.
///
///     set  = item ("," item)*          spaces around items are allowed
///     item = a | range | range "x" n | range "y" n
///     range = a "-" b | a ".." b
///
/// `1-10x3` is every third frame (1,4,7,10), `1-10y3` are the others (2,3,5,6,8,9). Numbers may be negative
/// (`-8--5`) and ranges may descend (`10-1`). ":" is refused: it is a step in some programs and a stagger in
/// others.
class FrameSet {
public:
    static constexpr std::size_t kLargest = 10'000'000;

    /// Throws Error(usage) with what would be right; also above kLargest frames, before they are allocated.
    static FrameSet parse(std::string_view text);
    /// first, first + 1, ..., last; throws like parse().
    static FrameSet range(std::int64_t first, std::int64_t last);

    const std::vector<std::int64_t>& frames() const { return frames_; }
    /// How many repeated frames were dropped.
    std::size_t duplicates() const { return duplicates_; }

private:
    std::vector<std::int64_t> frames_;
    std::size_t duplicates_ = 0;
};

/// A short text that parses to the same frames in the same order.
std::string to_string(const FrameSet& set);

}  // namespace dapple
