#include "judge/block_signals.h"

#include <limits>
#include <utility>

#include "base/parallel.h"

namespace dapple::judge {
namespace {

constexpr int kSmallestBlock = 8;  // pixels
constexpr int kBlocksASide = 64;   // at most
constexpr std::size_t kTilePixels = 1 << 14;

float middle(float a, float b, float c) {
    return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

/// What shows in one frame only: 0 for a value between its neighbours'; with its sign.
float alone(float before, float now, float after, float floor) {
    return (now - middle(before, now, after)) *
           evenness(std::abs(now - before), std::abs(after - now), floor);
}

/// body(block, its pixels), blocks in parallel.
template <typename PerBlock>
void for_blocks(const BlockGrid& grid, const PerBlock& body) {
    parallel_for(grid.count(), static_cast<std::size_t>(grid.columns),
                 [&](std::size_t begin, std::size_t end) {
                     for (std::size_t block = begin; block < end; ++block) body(block, grid.box_of(block));
                 });
}

}  // namespace

BlockGrid::BlockGrid(int picture_width, int picture_height)
    : width(picture_width),
      height(picture_height),
      side(std::max(kSmallestBlock, (std::max(width, height) + kBlocksASide - 1) / kBlocksASide)),
      columns((width + side - 1) / side),
      rows((height + side - 1) / side) {}

Box BlockGrid::box_of(std::size_t block) const {
    const int x = static_cast<int>(block % static_cast<std::size_t>(columns)) * side;
    const int y = static_cast<int>(block / static_cast<std::size_t>(columns)) * side;
    return {x, y, std::min(side, width - x), std::min(side, height - y)};
}

SignalMeter::SignalMeter(const BlockGrid& grid, double level)
    : grid_(grid), level_(static_cast<float>(level)) {}

void SignalMeter::add(const metrics::Picture& picture, const metrics::Picture* reference,
                      BlockSignals& signals, BlockSignals* before) {
    add_plane(plane_of(picture, reference));
    const std::size_t planes = planes_.size();
    if (planes < 2 || planes_[planes - 2].empty()) return;
    compare_with_before(signals);
    if (planes == 3 && !planes_[0].empty()) compare_with_both(*before);
}

void SignalMeter::add_gap() {
    add_plane({});
}

void SignalMeter::add_plane(Plane plane) {
    planes_.push_back(std::move(plane));
    if (planes_.size() > 3) planes_.pop_front();
}

SignalMeter::Plane SignalMeter::plane_of(const metrics::Picture& picture,
                                         const metrics::Picture* reference) const {
    const auto bounded = [this](float luminance) {
        return luminance > 0 ? luminance / (luminance + level_) : 0;
    };
    Plane plane(picture.pixels());
    parallel_for(plane.size(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            plane[i] = bounded(picture.luminance[i]);
            if (reference != nullptr) plane[i] -= bounded(reference->luminance[i]);
        }
    });
    // NaN takes a pixel out of all that follows.
    for (const std::uint32_t pixel : picture.excluded) plane[pixel] = std::numeric_limits<float>::quiet_NaN();
    return plane;
}

void SignalMeter::compare_with_before(BlockSignals& signals) const {
    const Plane& before = planes_[planes_.size() - 2];
    const Plane& now = planes_[planes_.size() - 1];
    const std::size_t blocks = grid_.count();
    signals.change.assign(blocks, 0);
    std::vector<double> sums(blocks), counts(blocks);
    for_blocks(grid_, [&](std::size_t block, const Box& box) {
        Plane changes;
        double sum = 0;
        for (int y = box.y; y < box.y + box.height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) +
                                    static_cast<std::size_t>(box.x);
            for (std::size_t i = row; i < row + static_cast<std::size_t>(box.width); ++i) {
                const float change = std::abs(now[i] - before[i]);
                if (std::isnan(change)) continue;
                changes.push_back(change);
                sum += static_cast<double>(change);
            }
        }
        sums[block] = sum;
        counts[block] = static_cast<double>(changes.size());
        signals.change[block] = median_of(changes);
    });
    double sum = 0, count = 0;
    for (std::size_t block = 0; block < blocks; ++block) {
        sum += sums[block];
        count += counts[block];
    }
    signals.mean_change = count > 0 ? sum / count : 0;
}

void SignalMeter::compare_with_both(BlockSignals& signals) const {
    const Plane& before = planes_[0];
    const Plane& now = planes_[1];
    const Plane& after = planes_[2];
    const std::size_t blocks = grid_.count();
    signals.lone.assign(blocks, 0);
    signals.offset.assign(blocks, 0);
    signals.bend.assign(blocks, 0);
    struct Sums {
        double before = 0, now = 0, after = 0, count = 0;
    };
    std::vector<Sums> sums(blocks);
    for_blocks(grid_, [&](std::size_t block, const Box& box) {
        Plane lone;
        Sums& sum = sums[block];
        for (int y = box.y; y < box.y + box.height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) +
                                    static_cast<std::size_t>(box.x);
            for (std::size_t i = row; i < row + static_cast<std::size_t>(box.width); ++i) {
                if (std::isnan(before[i] + now[i] + after[i])) continue;
                lone.push_back(std::abs(now[i] - middle(before[i], now[i], after[i])));
                sum.before += static_cast<double>(before[i]);
                sum.now += static_cast<double>(now[i]);
                sum.after += static_cast<double>(after[i]);
            }
        }
        sum.count = static_cast<double>(lone.size());
        if (lone.empty()) return;
        const auto mean = [&](double total) { return static_cast<float>(total / sum.count); };
        signals.lone[block] = median_of(lone);
        signals.offset[block] =
            alone(mean(sum.before), mean(sum.now), mean(sum.after), static_cast<float>(kBlockFloor));
        signals.bend[block] = std::abs(mean(sum.now) - (mean(sum.before) + mean(sum.after)) / 2);
    });
    Sums all;
    for (const Sums& sum : sums) {
        all.before += sum.before;
        all.now += sum.now;
        all.after += sum.after;
        all.count += sum.count;
    }
    if (all.count == 0) all.count = 1;
    const auto mean = [&](double total) { return static_cast<float>(total / all.count); };
    signals.mean_offset = static_cast<double>(
        alone(mean(all.before), mean(all.now), mean(all.after), static_cast<float>(kFrameFloor)));
    signals.mean_bend = std::abs(all.now - (all.before + all.after) / 2) / all.count;
}

}  // namespace dapple::judge
