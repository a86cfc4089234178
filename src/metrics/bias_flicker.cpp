#include "metrics/bias_flicker.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "metrics/counted.h"
#include "metrics/share.h"

namespace dapple::metrics {
namespace {

struct ReferenceSum {
    double squares = 0;
    void operator+=(const ReferenceSum& other) { squares += other.squares; }
};

struct SplitSums {
    double bias = 0, variance = 0;
    std::size_t pixels = 0;
    void operator+=(const SplitSums& other) {
        bias += other.bias;
        variance += other.variance;
        pixels += other.pixels;
    }
};

}  // namespace

void BiasFlicker::add(const Picture& picture, const Picture& reference) {
    assert(picture.excluded == reference.excluded);
    assert(picture.luminance.size() == reference.luminance.size());
    if (counts_.empty()) {
        mean_.resize(picture.pixels());
        squares_.resize(picture.pixels());
        counts_.resize(picture.pixels());
    }
    assert(counts_.size() == picture.pixels());
    const auto sum = sum_counted<ReferenceSum>(
        picture.pixels(), picture.excluded, [&](ReferenceSum& tile, std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const auto r = static_cast<double>(reference.luminance[i]);
                const double error = static_cast<double>(picture.luminance[i]) - r;
                // Welford 1962: no difference of large sums, so that a constant error has no variance.
                const double step = error - mean_[i];
                mean_[i] += step / ++counts_[i];
                squares_[i] += step * (error - mean_[i]);
                tile.squares += r * r;
            }
        });
    reference_squares_ += sum.squares;
    counted_ += picture.counted();
}

BiasFlicker::Split BiasFlicker::split() const {
    const auto sums =
        sum_counted<SplitSums>(counts_.size(), {}, [&](SplitSums& tile, std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                if (counts_[i] == 0) continue;
                tile.bias += mean_[i] * mean_[i];
                tile.variance += squares_[i] / counts_[i];
                ++tile.pixels;
            }
        });
    if (sums.pixels == 0) return {};
    const double reference = reference_squares_ / static_cast<double>(counted_);
    const auto pixels = static_cast<double>(sums.pixels);
    return {share_of(sums.bias / pixels, reference), share_of(sums.variance / pixels, reference)};
}

std::vector<float> BiasFlicker::deviation_map() const {
    std::vector<float> map(counts_.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
        if (counts_[i] > 0) map[i] = static_cast<float>(std::sqrt(squares_[i] / counts_[i]));
    }
    return map;
}

}  // namespace dapple::metrics
