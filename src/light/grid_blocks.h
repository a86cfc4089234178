#pragma once
#include <algorithm>
#include <cstddef>
#include <utility>

namespace dapple::light {

/// Order of visiting a grid that keeps rays coherent: bands of eight rows, cut into blocks of 8 x 8, each as
/// 4 x 2 groups of a packet's eight rays. A band is a tile of the parallel loop.
class GridBlocks {
public:
    GridBlocks(int rows, int columns)
        : rows_(static_cast<std::size_t>(rows)), columns_(static_cast<std::size_t>(columns)) {}
    std::size_t bands() const { return (rows_ + kSide - 1) / kSide; }
    std::size_t band_size() const { return kSide * columns_; }  ///< vertices, at most

    /// Of a band's vertices, the first and the one after the last.
    std::pair<std::ptrdiff_t, std::ptrdiff_t> band_range(std::size_t band) const {
        const std::size_t top = band * kSide, bottom = std::min(rows_, top + kSide);
        return {static_cast<std::ptrdiff_t>(top * columns_), static_cast<std::ptrdiff_t>(bottom * columns_)};
    }

    /// A packet's vertices: up to four of a row, and as many below them.
    struct Group {
        std::size_t first;  ///< index of the upper left one
        std::size_t columns, rows;
        bool whole() const { return columns == 4 && rows == 2; }
    };
    /// `visit(group)` for each group of the band.
    template <class Visit>
    void visit_groups(std::size_t band, Visit&& visit) const {
        const std::size_t top = band * kSide, bottom = std::min(rows_, top + kSide);
        for (std::size_t left = 0; left < columns_; left += kSide)
            for (std::size_t row = top; row < bottom; row += 2)
                for (std::size_t column = left; column < std::min(columns_, left + kSide); column += 4)
                    visit(Group{row * columns_ + column, std::min<std::size_t>(4, columns_ - column),
                                std::min<std::size_t>(2, bottom - row)});
    }
    /// `visit(index)` for each vertex of the band.
    template <class Visit>
    void visit_band(std::size_t band, Visit&& visit) const {
        visit_groups(band, [&](const Group& group) {
            for (std::size_t r = 0; r < group.rows; ++r)
                for (std::size_t c = 0; c < group.columns; ++c) visit(group.first + r * columns_ + c);
        });
    }

private:
    static constexpr std::size_t kSide = 8;
    std::size_t rows_;
    std::size_t columns_;
};

}  // namespace dapple::light
