#include "methods/reference/strata_layout.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dapple::reference {
namespace {

/// Of the strata that all tiles share.
constexpr double kEven = 0.1;

}  // namespace

StrataLayout::StrataLayout(double aspect, std::size_t strata) : aspect_(aspect) {
    if (aspect > 0) {
        columns_ = static_cast<std::size_t>(
            std::clamp(std::round(std::sqrt(kTiles * aspect)), 1.0, static_cast<double>(kTiles)));
        rows_ = kTiles / columns_;
    }
    const std::size_t tiles = columns_ * rows_;
    for (std::size_t i = 0; i < tiles; ++i) add(static_cast<double>(strata) / static_cast<double>(tiles));
}

StrataLayout::StrataLayout(const StrataLayout& tiles, const std::vector<double>& weights, std::size_t strata)
    : aspect_(tiles.aspect_), columns_(tiles.columns_), rows_(tiles.rows_) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const double even = 1 / static_cast<double>(weights.size());
    for (const double weight : weights) {
        const double share = sum > 0 ? kEven * even + (1 - kEven) * weight / sum : even;
        add(share * static_cast<double>(strata));
    }
}

void StrataLayout::add(double strata) {
    const double wide =
        aspect_ > 0 ? aspect_ * static_cast<double>(rows_) / static_cast<double>(columns_) : 1;
    const double most = std::max(1.0, std::round(strata));
    const double across = aspect_ > 0 ? std::clamp(std::round(std::sqrt(most * wide)), 1.0, most) : most;
    across_.push_back(static_cast<std::uint32_t>(across));
    down_.push_back(static_cast<std::uint32_t>(std::max(1.0, std::round(most / across))));
    first_.push_back(first_.back() + std::size_t{across_.back()} * down_.back());
}

std::size_t StrataLayout::tile(std::size_t stratum) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), stratum);
    return static_cast<std::size_t>(after - first_.begin()) - 1;
}

StrataLayout::Cell StrataLayout::cell(std::size_t stratum) const {
    const std::size_t at = tile(stratum), within = stratum - first_[at];
    const std::size_t column = at % columns_, row = at / columns_;
    const std::size_t x = within % across_[at], y = within / across_[at];
    const double tile_width = 1 / static_cast<double>(columns_), tile_height = 1 / static_cast<double>(rows_);
    const double width = tile_width / across_[at], height = tile_height / down_[at];
    return {tile_width * static_cast<double>(column) + width * static_cast<double>(x),
            tile_height * static_cast<double>(row) + height * static_cast<double>(y), width, height};
}

std::vector<double> StrataLayout::widened(const std::vector<double>& values) const {
    std::vector<double> result(values.size(), 0);
    for (std::size_t row = 0; row < rows_; ++row) {
        for (std::size_t column = 0; column < columns_; ++column) {
            double& largest = result[row * columns_ + column];
            for (std::size_t y = row - std::min<std::size_t>(row, 1); y < std::min(rows_, row + 2); ++y)
                for (std::size_t x = column - std::min<std::size_t>(column, 1);
                     x < std::min(columns_, column + 2); ++x)
                    largest = std::max(largest, values[y * columns_ + x]);
        }
    }
    return result;
}

}  // namespace dapple::reference
