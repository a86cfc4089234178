#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "metrics/flip_kernels.h"
#include "metrics/picture.h"

namespace dapple::metrics {

/// Columns and rows of a picture, ends excluded.
struct FlipTile {
    std::size_t left = 0, right = 0, top = 0, bottom = 0;
};

/// What FLIP compares of one picture, row by row from the top of a tile: Hunt-adjusted CIELAB of the picture
/// as the eye blurs it, and how strongly edges and points stand out of the picture as it is. Holds a few rows
/// only, so that a tile's work stays in the cache.
class FlipRows {
public:
    FlipRows(const Picture& picture, const FlipKernels& kernels, const FlipTile& tile);

    /// Starts at the tile's top. Without an exposure the picture holds sRGB code values; with one, linear
    /// values that are multiplied by 2^exposure and tone-mapped (Andersson et al. 2021).
    void start(std::optional<double> exposure);
    /// The next row of the tile.
    void advance();

    /// Of the current row, a value a column of the tile, padded to whole vectors.
    enum Value : std::size_t { kLightness, kGreenRed, kBlueYellow, kEdge, kPoint, kValues };
    const float* operator[](Value value) const { return values_[value].data(); }

private:
    /// Y / Y_n, X / X_n - Y / Y_n, Y / Y_n - Z / Z_n: YCxCz without its scales and offset.
    enum Opponent : std::size_t { kY, kCx, kCz, kOpponents };
    /// Those filtered down the columns, by the kernels' names.
    enum Column : std::size_t { kLuminance, kRedGreen, kWide, kNarrow, kGaussian, kEdges, kPoints, kColumns };
    /// And then across the rows; features by the direction of their derivative.
    enum Filtered : std::size_t {
        kFilteredY,
        kFilteredCx,
        kFilteredCzWide,
        kFilteredCzNarrow,
        kEdgeAcross,
        kPointAcross,
        kEdgeDown,
        kPointDown,
        kFiltered
    };

    void convert(std::size_t y);
    void filter_down();
    void filter_across();
    void set_values();

    const Picture& picture_;
    const FlipKernels& kernels_;
    FlipTile tile_;
    std::size_t width_;          ///< of the tile
    std::size_t padded_width_;   ///< with the kernels' radius on both sides
    std::optional<float> gain_;  ///< none for sRGB
    std::size_t row_ = 0;        ///< to come
    std::size_t converted_ = 0;  ///< rows above it are in the ring
    std::array<std::vector<std::vector<float>>, kOpponents> ring_;  ///< by row modulo 2 radius + 1
    std::array<std::vector<const float*>, kOpponents> sources_;     ///< rows at -radius ... radius
    std::vector<const float*> steps_;                               ///< a row's columns at -radius ... radius
    std::array<std::vector<float>, kColumns> columns_;
    std::array<std::vector<float>, kFiltered> across_;
    std::array<std::vector<float>, kValues> values_;
};

/// FLIP of two rows: out[x] for `count` columns, rounded up to whole vectors.
void compare_rows(const FlipRows& picture, const FlipRows& reference, std::size_t count, float* out);

}  // namespace dapple::metrics
