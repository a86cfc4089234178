#include "methods/reference/deposit_cells.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace dapple::reference {
namespace {

/// Fewer paths say nothing of their spacing.
constexpr std::size_t kFewPaths = 64;

/// A stretch of the sorted paths: those in one quarter.
struct Quarter {
    std::size_t begin = 0;
    std::size_t end = 0;
    int level = 0;       ///< digits that its paths share
    int least_cell = 0;  ///< its cells have at least as many digits
    std::size_t paths() const { return end - begin; }
};

}  // namespace

struct DepositCells::Builder {
    DepositCells& out;
    const std::vector<PathEnd>& ends;
    std::vector<std::uint8_t> differs;  ///< first digit in which a key differs from the one before it

    Builder(DepositCells& cells, const std::vector<PathEnd>& sorted) : out(cells), ends(sorted) {
        differs.resize(ends.size());
        for (std::size_t i = 1; i < ends.size(); ++i) {
            const std::uint64_t change = ends[i].key ^ ends[i - 1].key;
            const int place = change == 0 ? -1 : (static_cast<int>(std::bit_width(change)) - 1) / 2;
            differs[i] = static_cast<std::uint8_t>(std::max(0, out.digits_ - 1 - place));
        }
    }

    std::uint64_t digit(std::uint64_t key, int level) const {
        return key >> (2 * (out.digits_ - 1 - level)) & 3;
    }

    /// The fewest digits at which fewer than 3.5 paths share a cell, on average over cells with any.
    int own_level(const Quarter& quarter) const {
        std::array<std::size_t, 33> new_cells{};
        for (std::size_t i = quarter.begin + 1; i < quarter.end; ++i) ++new_cells[differs[i]];
        std::size_t cells = 1;
        for (int level = 0; level < out.digits_; ++level) {
            if (level > quarter.level) cells += new_cells[static_cast<std::size_t>(level) - 1];
            if (level >= quarter.level && 2 * quarter.paths() < 7 * cells) return level;
        }
        return out.digits_;
    }

    std::int32_t add_tile(const Quarter& quarter, int cell_level) {
        Tile tile;
        tile.level = static_cast<std::uint8_t>(quarter.level);
        tile.cell_digits = static_cast<std::uint8_t>(cell_level - quarter.level);
        tile.first_cell = static_cast<std::uint32_t>(out.first_path_.size());
        const std::size_t cells = std::size_t{1} << (2 * tile.cell_digits);
        const int shift = 2 * (out.digits_ - cell_level);
        std::size_t path = quarter.begin;
        for (std::size_t cell = 0; cell < cells; ++cell) {
            out.first_path_.push_back(static_cast<std::uint32_t>(path));
            while (path < quarter.end && (ends[path].key >> shift & (cells - 1)) == cell) ++path;
        }
        out.first_path_.push_back(static_cast<std::uint32_t>(path));
        assert(path == quarter.end);
        out.tiles_.push_back(tile);
        return ~static_cast<std::int32_t>(out.tiles_.size() - 1);
    }

    std::int32_t add(const Quarter& quarter) {
        const bool few = quarter.paths() < kFewPaths;
        const int own = few && quarter.level > 0 ? 0 : own_level(quarter);
        const int cell_level = std::min(out.digits_, std::max({quarter.level, own, quarter.least_cell}));
        const int cell_digits = cell_level - quarter.level;
        const bool filled = cell_digits < 15 && (std::size_t{1} << (2 * cell_digits)) <= 4 * quarter.paths();
        const bool small = quarter.paths() <= kTilePaths && filled;
        if (small || quarter.level == out.digits_) return add_tile(quarter, cell_level);
        const auto node = static_cast<std::int32_t>(out.nodes_.size());
        out.nodes_.emplace_back();
        // Where there are too few paths to say, the spacing around them is the best guess; else it may
        // change by a factor of two on the way down.
        const int least_cell = few ? cell_level : cell_level - 1;
        Quarter child{quarter.begin, quarter.begin, quarter.level + 1, least_cell};
        for (std::uint64_t which = 0; which < 4; ++which) {
            child.begin = child.end;
            while (child.end < quarter.end && digit(ends[child.end].key, quarter.level) == which) ++child.end;
            if (child.paths() == 0) continue;
            Quarter inner = child;
            if (inner.paths() < kFewPaths) inner.least_cell = cell_level;
            const std::int32_t added = add(inner);
            out.nodes_[static_cast<std::size_t>(node)].child[which] = added;
        }
        return node;
    }
};

DepositCells::DepositCells(std::vector<PathEnd> ends, std::size_t charts, int digits) : digits_(digits) {
    assert(ends.size() < std::numeric_limits<std::uint32_t>::max());
    std::sort(ends.begin(), ends.end(), [](const PathEnd& a, const PathEnd& b) {
        return a.key != b.key ? a.key < b.key : a.pixel < b.pixel;
    });
    roots_.assign(charts, kNothing);
    Builder builder(*this, ends);
    for (std::size_t begin = 0; begin < ends.size();) {
        const std::uint64_t chart = ends[begin].key >> (2 * digits_);
        std::size_t end = begin;
        while (end < ends.size() && ends[end].key >> (2 * digits_) == chart) ++end;
        roots_[static_cast<std::size_t>(chart)] = builder.add({begin, end, 0, 0});
        begin = end;
    }
    pixels_.reserve(ends.size());
    for (const PathEnd& end : ends) pixels_.push_back(end.pixel);
    first_path_.shrink_to_fit();
}

DepositCells::Cell DepositCells::find(std::uint64_t key) const {
    std::int32_t at = roots_[static_cast<std::size_t>(key >> (2 * digits_))];
    int shift = 2 * digits_;
    while (at >= 0) {
        shift -= 2;
        at = nodes_[static_cast<std::size_t>(at)].child[key >> shift & 3];
    }
    if (at == kNothing) return {};
    const std::int32_t number = ~at;
    const Tile& tile = tiles_[static_cast<std::size_t>(number)];
    const int cell_level = tile.level + tile.cell_digits;
    const std::uint64_t mask = (std::uint64_t{1} << (2 * tile.cell_digits)) - 1;
    const std::size_t cell = tile.first_cell + (key >> (2 * (digits_ - cell_level)) & mask);
    const std::uint32_t begin = first_path_[cell];
    return {std::span(pixels_).subspan(begin, first_path_[cell + 1] - begin),
            std::ldexp(1.0, 2 * cell_level)};
}

std::size_t DepositCells::bytes() const {
    return roots_.size() * sizeof(std::int32_t) + nodes_.size() * sizeof(Node) +
           tiles_.size() * sizeof(Tile) + (first_path_.size() + pixels_.size()) * sizeof(std::uint32_t);
}

}  // namespace dapple::reference
