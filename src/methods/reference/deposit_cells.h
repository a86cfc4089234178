#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dapple::reference {

/// Where one sub-pixel camera path ended.
struct PathEnd {
    std::uint64_t key = 0;    ///< ChartPlace::key
    std::uint32_t pixel = 0;  ///< its pixel
};

/// The cells of the charts in which light is counted, and the pixels that see them. A pixel's E is the mean,
/// over its camera paths, of E in the cells that these hit; so light that lands in a cell counts for each
/// path that hits it, and nothing is stored a cell but those paths.
///
/// A chart is a tree of quarters. Its tiles are the largest quarters that at most kTilePaths paths hit and
/// that these fill to a quarter at least; a tile is cut into 4^k equal cells, one to two times as wide as the
/// paths are spaced: k is the least at which fewer than 3.5 paths share a cell. (Smaller cells would leave
/// gaps between them, and lose what is gained by stratified light.) So where paths and quarters are aligned
/// they are one to one. Tiles of few paths, whose spacing means little, take the size of cells of the quarter
/// around them, and no tile's cells are more than twice as wide as those that its parent would have. Quarters
/// without paths hold nothing.
class DepositCells {
public:
    static constexpr std::size_t kTilePaths = 4096;

    DepositCells() = default;
    /// `digits` as ReceiverCharts::digits(). The result does not depend on the order of `ends`, which are
    /// consumed.
    DepositCells(std::vector<PathEnd> ends, std::size_t charts, int digits);

    struct Cell {
        std::span<const std::uint32_t> pixels;  ///< of the paths that hit it, with repetitions
        double per_measure = 0;                 ///< 1 / measure of the cell: 4^level
    };
    /// The cell of a place; no pixels where no path comes near.
    Cell find(std::uint64_t key) const;

    std::size_t cells() const { return first_path_.size() - tiles_.size(); }
    std::size_t bytes() const;

private:
    /// Children: >= 0 a node, kNothing, or ~tile.
    static constexpr std::int32_t kNothing = INT32_MIN;
    struct Node {
        std::array<std::int32_t, 4> child{kNothing, kNothing, kNothing, kNothing};
    };
    struct Tile {
        std::uint32_t first_cell = 0;  ///< index into first_path_
        std::uint8_t level = 0;        ///< digits of its key
        std::uint8_t cell_digits = 0;  ///< further digits of its cells
    };
    struct Builder;

    int digits_ = 0;
    std::vector<std::int32_t> roots_;  ///< a chart, as Node::child
    std::vector<Node> nodes_;
    std::vector<Tile> tiles_;
    /// Of the cells, tile by tile: where its paths begin; one more entry ends each tile.
    std::vector<std::uint32_t> first_path_;
    std::vector<std::uint32_t> pixels_;  ///< of the paths, in the order of their keys
};

}  // namespace dapple::reference
