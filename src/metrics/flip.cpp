#include "metrics/flip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "metrics/flip_rows.h"
#include "metrics/lanes.h"

namespace dapple::metrics {
namespace {

/// Small enough that the rows in work stay in a core's cache, large enough that the margin, which neighbours
/// compute too, costs little.
constexpr std::size_t kTileWidth = 480;
constexpr std::size_t kTileHeight = 180;

/// Value of the map that halves the sum of all: the smallest whose sum with those below is half of it or
/// more.
double weighted_median(const std::vector<float>& map, double total) {
    // By bins of equal width, then by order within the bin where the half lies.
    constexpr std::size_t kBins = 4096;
    const auto bin_of = [](float value) {
        return std::min(kBins - 1, static_cast<std::size_t>(value * static_cast<float>(kBins)));
    };
    std::vector<double> sums(kBins);
    for (const float value : map) sums[bin_of(value)] += static_cast<double>(value);
    double below = 0;
    std::size_t bin = 0;
    while (bin + 1 < kBins && below + sums[bin] < 0.5 * total) below += sums[bin++];
    std::vector<float> values;
    std::ranges::copy_if(map, std::back_inserter(values), [&](float value) { return bin_of(value) == bin; });
    std::ranges::sort(values);
    for (const float value : values) {
        below += static_cast<double>(value);
        if (below >= 0.5 * total) return static_cast<double>(value);
    }
    return values.empty() ? 0 : static_cast<double>(values.back());
}

/// The map's figures; excluded pixels count nowhere.
void summarise(Flip& flip, const Picture& picture) {
    for (const std::uint32_t pixel : picture.excluded) flip.map[pixel] = 0;
    constexpr std::size_t kTile = std::size_t{1} << 15;
    struct Part {
        double total = 0;
        float largest = 0;
    };
    std::vector<Part> parts((flip.map.size() + kTile - 1) / kTile);
    parallel_for(flip.map.size(), kTile, [&](std::size_t begin, std::size_t end) {
        Doubles totals{};
        float largest = 0;
        for (std::size_t i = begin; i < end; i += kDoubleLanes) {
            totals += load_doubles(flip.map.data() + i, end - i);
        }
        for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, flip.map[i]);
        parts[begin / kTile] = {sum(totals), largest};
    });
    double total = 0;
    for (const Part& part : parts) {
        total += part.total;
        flip.largest = std::max(flip.largest, static_cast<double>(part.largest));
    }
    if (picture.counted() > 0) flip.mean = total / static_cast<double>(picture.counted());
    flip.weighted_median = weighted_median(flip.map, total);
}

/// Pairs by the indices of their pictures, each of which is there once.
struct IndexedPairs {
    struct Pair {
        std::size_t picture = 0, reference = 0;
    };
    std::vector<const Picture*> pictures;
    std::vector<Pair> pairs;

    explicit IndexedPairs(const std::vector<FlipPair>& given) {
        for (const auto& [picture, reference] : given) {
            assert(picture->width == given[0].picture->width && picture->height == given[0].picture->height);
            assert(picture->width == reference->width && picture->height == reference->height);
            assert(picture->excluded == reference->excluded);
            pairs.push_back({index_of(picture), index_of(reference)});
        }
    }

private:
    std::size_t index_of(const Picture* picture) {
        const auto found = std::ranges::find(pictures, picture);
        const auto index = static_cast<std::size_t>(found - pictures.begin());
        if (found == pictures.end()) pictures.push_back(picture);
        return index;
    }
};

/// Raises the maps, one a pair, to FLIP of a tile at each of the exposures; no exposure stands for sRGB.
void raise_maps(const IndexedPairs& pairs, const FlipKernels& kernels, const FlipTile& tile,
                const std::vector<std::optional<double>>& exposures, std::vector<Flip>& flips) {
    std::vector<FlipRows> rows;
    rows.reserve(pairs.pictures.size());
    for (const Picture* picture : pairs.pictures) rows.emplace_back(*picture, kernels, tile);
    const std::size_t width = static_cast<std::size_t>(pairs.pictures[0]->width);
    const std::size_t count = tile.right - tile.left;
    std::vector<float> values((count + kFloatLanes - 1) / kFloatLanes * kFloatLanes);
    for (const std::optional<double>& exposure : exposures) {
        for (FlipRows& picture : rows) picture.start(exposure);
        for (std::size_t y = tile.top; y < tile.bottom; ++y) {
            for (FlipRows& picture : rows) picture.advance();
            for (std::size_t i = 0; i < flips.size(); ++i) {
                const auto [picture, reference] = pairs.pairs[i];
                compare_rows(rows[picture], rows[reference], count, values.data());
                float* const out = flips[i].map.data() + y * width + tile.left;
                for (std::size_t x = 0; x < count; ++x) out[x] = std::max(out[x], values[x]);
            }
        }
    }
}

/// The largest of the given exposures; no exposure stands for sRGB.
std::vector<Flip> largest_flips(const std::vector<FlipPair>& given,
                                const std::vector<std::optional<double>>& exposures,
                                double pixels_per_degree) {
    std::vector<Flip> flips(given.size());
    if (given.empty()) return flips;
    const IndexedPairs pairs(given);
    for (Flip& flip : flips) flip.map.resize(pairs.pictures[0]->pixels());
    const std::size_t width = static_cast<std::size_t>(pairs.pictures[0]->width);
    const std::size_t height = static_cast<std::size_t>(pairs.pictures[0]->height);
    const std::size_t across = (width + kTileWidth - 1) / kTileWidth;
    const std::size_t down = (height + kTileHeight - 1) / kTileHeight;
    const FlipKernels kernels = flip_kernels(pixels_per_degree);
    parallel_for(across * down, 1, [&](std::size_t index, std::size_t) {
        FlipTile tile;
        tile.left = index % across * kTileWidth;
        tile.right = std::min(width, tile.left + kTileWidth);
        tile.top = index / across * kTileHeight;
        tile.bottom = std::min(height, tile.top + kTileHeight);
        raise_maps(pairs, kernels, tile, exposures, flips);
    });
    for (std::size_t i = 0; i < flips.size(); ++i) summarise(flips[i], *given[i].reference);
    return flips;
}

}  // namespace

Exposures exposures_of(const std::vector<const Picture*>& references) {
    double largest = 0;
    std::vector<float> luminances, positive;
    for (const Picture* reference : references) {
        std::size_t excluded = 0;
        for (std::size_t i = 0; i < reference->pixels(); ++i) {
            if (excluded < reference->excluded.size() && reference->excluded[excluded] == i) {
                ++excluded;
                continue;
            }
            const float luminance = 0.2126f * reference->rgb[0][i] + 0.7152f * reference->rgb[1][i] +
                                    0.0722f * reference->rgb[2][i];
            luminances.push_back(luminance);
            if (luminance > 0) positive.push_back(luminance);
            largest = std::max(largest, static_cast<double>(luminance));
        }
    }
    if (positive.empty()) return {};
    const auto median = [](std::vector<float>& values) {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::ranges::nth_element(values, middle);
        return static_cast<double>(*middle);
    };
    double middle = median(luminances);
    if (middle <= 0) middle = median(positive);
    // 0.85 = (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5) of the tone curve.
    const double a = 0.36 * (2.51 - 0.85 * 2.43), b = 0.6 * (0.03 - 0.85 * 0.59), c = -0.85 * 0.14;
    const double x = (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
    Exposures exposures;
    exposures.start = std::log2(x / largest);
    exposures.stop = std::log2(x / middle);
    exposures.count = static_cast<int>(
        std::clamp(std::ceil(exposures.stop - exposures.start), 2.0, double{kMostExposures}));
    return exposures;
}

std::vector<Flip> flips_ldr(const std::vector<FlipPair>& pairs, double pixels_per_degree) {
    return largest_flips(pairs, {std::nullopt}, pixels_per_degree);
}

std::vector<Flip> flips_hdr(const std::vector<FlipPair>& pairs, const Exposures& exposures,
                            double pixels_per_degree) {
    assert(exposures.count >= 2);
    std::vector<std::optional<double>> stops;
    stops.reserve(static_cast<std::size_t>(exposures.count));
    for (int i = 0; i < exposures.count; ++i) {
        stops.emplace_back(exposures.start + i * (exposures.stop - exposures.start) / (exposures.count - 1));
    }
    return largest_flips(pairs, stops, pixels_per_degree);
}

Flip flip_ldr(const Picture& picture, const Picture& reference, double pixels_per_degree) {
    return std::move(flips_ldr({{&picture, &reference}}, pixels_per_degree)[0]);
}

Flip flip_hdr(const Picture& picture, const Picture& reference, const Exposures& exposures,
              double pixels_per_degree) {
    return std::move(flips_hdr({{&picture, &reference}}, exposures, pixels_per_degree)[0]);
}

}  // namespace dapple::metrics
