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
        columns_ = static_cast<int>(std::clamp(std::round(std::sqrt(kTiles * aspect)), 1.0, 1.0 * kTiles));
        rows_ = kTiles / columns_;
    }
    const auto tiles = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
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
    const double wide = aspect_ > 0 ? aspect_ * rows_ / columns_ : 1;
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
    const auto columns = static_cast<std::size_t>(columns_);
    const double width = 1.0 / columns_ / across_[at], height = 1.0 / rows_ / down_[at];
    return {static_cast<double>(at % columns) / columns_ + width * static_cast<double>(within % across_[at]),
            static_cast<double>(at / columns) / rows_ + height * static_cast<double>(within / across_[at]),
            width, height};
}

std::vector<double> StrataLayout::widened(const std::vector<double>& values) const {
    std::vector<double> result(values.size(), 0);
    for (int row = 0; row < rows_; ++row) {
        for (int column = 0; column < columns_; ++column) {
            double& largest = result[static_cast<std::size_t>(row * columns_ + column)];
            for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y)
                for (int x = std::max(0, column - 1); x <= std::min(columns_ - 1, column + 1); ++x)
                    largest = std::max(largest, values[static_cast<std::size_t>(y * columns_ + x)]);
        }
    }
    return result;
}

}  // namespace dapple::reference
