#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dapple::reference {

/// Strata of the light rays of one lamp over the water, closer together where more of its light comes to
/// matter: the unit square (a height field's rectangle; one row along the triangles of a mesh) is cut into
/// equal tiles, each into its own number of equal strata. Wherever a tile has one at least, estimates have no
/// bias; the weights only tell where errors come from.
class StrataLayout {
public:
    static constexpr std::size_t kTiles = 1024;

    /// `aspect`: width of the rectangle over its height; 0: one row. All tiles have as many strata.
    StrataLayout(double aspect, std::size_t strata);
    /// About `strata`, shared by weight, but for a tenth that all tiles share. Errors fall least slowly when
    /// the weights are root mean squares of what a ray contributes.
    StrataLayout(const StrataLayout& tiles, const std::vector<double>& weights, std::size_t strata);

    std::size_t strata() const { return first_.back(); }
    std::size_t tiles() const { return across_.size(); }
    std::size_t tile(std::size_t stratum) const;
    /// Of the unit square.
    struct Cell {
        double x, y, width, height;
    };
    Cell cell(std::size_t stratum) const;
    /// The largest value of a tile and those that touch it.
    std::vector<double> widened(const std::vector<double>& values) const;

private:
    void add(double strata);

    double aspect_;
    std::size_t columns_ = kTiles, rows_ = 1;
    std::vector<std::uint32_t> across_, down_;  ///< strata of a tile
    std::vector<std::size_t> first_{0};         ///< of a tile, and one more
};

}  // namespace dapple::reference
