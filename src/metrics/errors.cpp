#include "metrics/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "metrics/lanes.h"

namespace dapple::metrics {
namespace {

constexpr std::size_t kBlock = 4;       ///< pixels along a side, as many as a vector has doubles
constexpr std::size_t kTileBlocks = 4;  ///< rows of blocks
static_assert(kBlock == kDoubleLanes);

/// Sums over some rows, all channels.
struct Sums {
    double reference = 0, difference = 0, absolute = 0, squares = 0, relative = 0;
    double block_squares = 0;  ///< of the means over blocks
    double largest = 0;        ///< |I - R|
};

/// The same of one channel, a lane each for every fourth column.
struct LaneSums {
    Doubles reference{}, difference{}, absolute{}, squares{}, relative{}, largest{};

    void add_to(Sums& sums) const {
        sums.reference += sum(reference);
        sums.difference += sum(difference);
        sums.absolute += sum(absolute);
        sums.squares += sum(squares);
        sums.relative += sum(relative);
        for (std::size_t lane = 0; lane < kDoubleLanes; ++lane) {
            sums.largest = std::max(sums.largest, largest[lane]);
        }
    }
};

/// Adds up to four pixels of a row; returns I - R.
Doubles add(LaneSums& sums, const float* picture, const float* reference, std::size_t count, double floor) {
    const Doubles r = load_doubles(reference, count);
    const Doubles d = load_doubles(picture, count) - r;
    const Doubles absolute = d < 0 ? -d : d;
    const Doubles squares = d * d;
    sums.reference += r;
    sums.difference += d;
    sums.absolute += absolute;
    sums.squares += squares;
    sums.relative += squares / (r * r + floor);
    sums.largest = absolute > sums.largest ? absolute : sums.largest;
    return d;
}

/// Sums over the rows of blocks [begin, end).
class BlockRows {
public:
    BlockRows(const Picture& picture, const Picture& reference, double floor)
        : picture_(picture), reference_(reference), floor_(floor) {}

    Sums sums(std::size_t begin, std::size_t end) const {
        Sums sums;
        for (std::size_t row = begin; row < end; ++row) {
            const std::vector<double> shares = counted_shares(row);
            for (std::size_t channel = 0; channel < 3; ++channel) add_row(sums, channel, row, shares);
        }
        return sums;
    }

    std::size_t rows() const { return (height() + kBlock - 1) / kBlock; }
    std::size_t columns() const { return (width() + kBlock - 1) / kBlock; }

    /// 1 / counted pixels of each block in the row, 0 where there is none.
    std::vector<double> counted_shares(std::size_t row) const {
        const std::size_t first = row * kBlock, last = std::min(height(), first + kBlock);
        std::vector<double> counts(columns());
        for (std::size_t block = 0; block < counts.size(); ++block) {
            const std::size_t across = std::min(kBlock, width() - block * kBlock);
            counts[block] = static_cast<double>(across * (last - first));
        }
        const std::vector<std::uint32_t>& excluded = reference_.excluded;
        auto pixel = std::ranges::lower_bound(excluded, first * width());
        for (; pixel != excluded.end() && *pixel < last * width(); ++pixel) {
            counts[*pixel % width() / kBlock] -= 1;
        }
        for (double& count : counts) count = count > 0 ? 1 / count : 0;
        return counts;
    }

private:
    std::size_t width() const { return static_cast<std::size_t>(reference_.width); }
    std::size_t height() const { return static_cast<std::size_t>(reference_.height); }

    void add_row(Sums& sums, std::size_t channel, std::size_t row, const std::vector<double>& shares) const {
        const std::size_t first = row * kBlock, last = std::min(height(), first + kBlock);
        const float* picture = picture_.rgb[channel].data();
        const float* reference = reference_.rgb[channel].data();
        LaneSums lanes;
        for (std::size_t block = 0; block < shares.size(); ++block) {
            const std::size_t x = block * kBlock, count = std::min(kBlock, width() - x);
            Doubles differences{};
            for (std::size_t y = first; y < last; ++y) {
                differences +=
                    add(lanes, picture + y * width() + x, reference + y * width() + x, count, floor_);
            }
            const double mean = sum(differences) * shares[block];
            sums.block_squares += mean * mean;
        }
        lanes.add_to(sums);
    }

    const Picture& picture_;
    const Picture& reference_;
    double floor_;  ///< of relative squares
};

/// First pixel of the rows whose largest |I - R| of the channels is `value`.
std::size_t pixel_of(const Picture& picture, const Picture& reference, std::size_t first_row, double value) {
    for (std::size_t i = first_row * static_cast<std::size_t>(picture.width); i < picture.pixels(); ++i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const double difference =
                static_cast<double>(picture.rgb[channel][i]) - static_cast<double>(reference.rgb[channel][i]);
            if (std::abs(difference) == value) return i;
        }
    }
    return 0;
}

}  // namespace

Errors errors_of(const Picture& picture, const Picture& reference, double peak, double clip_mean) {
    assert(picture.width == reference.width && picture.height == reference.height);
    assert(picture.excluded == reference.excluded);
    // The smallest floor keeps 0 / 0 out where the whole clip is black.
    const double floor = std::max(0.01 * clip_mean * clip_mean, std::numeric_limits<double>::min());
    const BlockRows blocks(picture, reference, floor);
    std::vector<Sums> tiles((blocks.rows() + kTileBlocks - 1) / kTileBlocks);
    parallel_for(blocks.rows(), kTileBlocks, [&](std::size_t begin, std::size_t end) {
        tiles[begin / kTileBlocks] = blocks.sums(begin, end);
    });

    Sums total;
    std::size_t worst_tile = 0;
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
        const Sums& sums = tiles[tile];
        total.reference += sums.reference;
        total.difference += sums.difference;
        total.absolute += sums.absolute;
        total.squares += sums.squares;
        total.relative += sums.relative;
        total.block_squares += sums.block_squares;
        if (sums.largest > total.largest) {
            total.largest = sums.largest;
            worst_tile = tile;
        }
    }
    std::size_t counted_blocks = blocks.rows() * blocks.columns();
    if (!reference.excluded.empty()) {
        counted_blocks = 0;
        for (std::size_t row = 0; row < blocks.rows(); ++row) {
            for (const double share : blocks.counted_shares(row)) counted_blocks += share > 0 ? 1 : 0;
        }
    }

    Errors errors;
    errors.excluded = reference.excluded.size();
    errors.psnr = std::numeric_limits<double>::infinity();
    if (reference.counted() == 0) return errors;
    const double count = 3 * static_cast<double>(reference.counted());
    errors.mean = total.reference / count;
    errors.bias = total.difference / count;
    errors.mae = total.absolute / count;
    errors.rmse = std::sqrt(total.squares / count);
    errors.block_rmse = std::sqrt(total.block_squares / (3 * static_cast<double>(counted_blocks)));
    errors.relative_mse = total.relative / count;
    if (total.squares > 0) errors.psnr = 10 * std::log10(peak * peak * count / total.squares);
    errors.largest = total.largest;
    if (total.largest > 0) {
        errors.largest_pixel = pixel_of(picture, reference, worst_tile * kTileBlocks * kBlock, total.largest);
    }
    return errors;
}

}  // namespace dapple::metrics
