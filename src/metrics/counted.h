#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <vector>

#include "base/parallel.h"
#include "metrics/picture.h"

/// Loops over the pixels that are counted, without a test at every pixel.
namespace dapple::metrics {

/// Pixels that any of the pictures excludes, ascending.
inline std::vector<std::uint32_t> excluded_by_any(std::initializer_list<const Picture*> pictures) {
    std::vector<std::uint32_t> all;
    for (const Picture* picture : pictures) {
        if (picture->excluded.empty()) continue;
        std::vector<std::uint32_t> both;
        std::ranges::set_union(all, picture->excluded, std::back_inserter(both));
        all = std::move(both);
    }
    return all;
}

/// Calls body(first, last) for each run of pixels of [begin, end) between excluded ones.
template <typename Body>
void for_each_run(const std::vector<std::uint32_t>& excluded, std::size_t begin, std::size_t end,
                  const Body& body) {
    auto next = std::ranges::lower_bound(excluded, begin);
    while (begin < end) {
        const std::size_t stop = next != excluded.end() ? std::min<std::size_t>(*next, end) : end;
        if (begin < stop) body(begin, stop);
        begin = stop + 1;
        if (next != excluded.end()) ++next;
    }
}

/// The sum of what add_run(sums, first, last) adds over all counted pixels of [0, pixels), the same on any
/// number of threads. `Sums` begins at zero and has +=.
template <typename Sums, typename AddRun>
Sums sum_counted(std::size_t pixels, const std::vector<std::uint32_t>& excluded, const AddRun& add_run) {
    constexpr std::size_t tile_pixels = 1 << 14;
    std::vector<Sums> tiles((pixels + tile_pixels - 1) / tile_pixels);
    parallel_for(pixels, tile_pixels, [&](std::size_t begin, std::size_t end) {
        Sums& sums = tiles[begin / tile_pixels];
        for_each_run(excluded, begin, end,
                     [&](std::size_t first, std::size_t last) { add_run(sums, first, last); });
    });
    Sums total;
    for (const Sums& sums : tiles) total += sums;
    return total;
}

}  // namespace dapple::metrics
