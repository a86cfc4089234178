#include "judge/defects_jumps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"

namespace dapple::judge {
namespace {

constexpr int kSmallestBlock = 8;    // pixels
constexpr int kBlocksASide = 64;     // at most: what is kept of a frame has a bound
constexpr double kFewBlocks = 0.25;  // the share up to which blocks are a region, not the frame
constexpr double kUneven = 0.6;
constexpr std::size_t kTilePixels = 1 << 14;
constexpr auto kFloor = static_cast<float>(JumpFinder::kBlockFloor);

float middle(float a, float b, float c) {
    return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

/// Upper median; 0 of nothing. Reorders.
template <typename T>
T median_of(std::vector<T>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

/// Where a frame differs from one neighbour far more than from the other, it is the other side of something
/// that happens to that neighbour, or between the two; where it differs from both alike, it is alone.
float evenness(float a, float b, float floor) {
    const float more = std::max(a, b);
    return more > 0 ? std::min(1.0f, (2 * std::min(a, b) + floor) / more) : 1.0f;
}

/// What shows in one frame only: 0 for a value between its neighbours'; with its sign.
float alone(float before, float now, float after, float floor) {
    return (now - middle(before, now, after)) *
           evenness(std::abs(now - before), std::abs(after - now), floor);
}

/// The second largest, so that another event close by does not count as usual; the larger of two.
float second_largest(std::vector<float>& values) {
    std::ranges::sort(values, std::ranges::greater());
    if (values.empty()) return 0;
    return values.size() > 2 ? values[1] : values[0];
}

Box united(const Box& a, const Box& b) {
    if (a.width == 0) return b;
    const int x = std::min(a.x, b.x);
    const int y = std::min(a.y, b.y);
    return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

}  // namespace

JumpFinder::JumpFinder(int width, int height, double level)
    : width_(width), height_(height), level_(static_cast<float>(level)) {
    block_ = std::max(kSmallestBlock, (std::max(width, height) + kBlocksASide - 1) / kBlocksASide);
    columns_ = (width + block_ - 1) / block_;
    rows_ = (height + block_ - 1) / block_;
}

JumpFinder::Plane JumpFinder::plane_of(const metrics::Picture& picture,
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

void JumpFinder::add(std::int64_t frame, const metrics::Picture& picture, const metrics::Picture* reference) {
    add_plane(frame, false, plane_of(picture, reference));
}

void JumpFinder::add_repeat(std::int64_t frame, const metrics::Picture& picture,
                            const metrics::Picture* reference) {
    add_plane(frame, true, plane_of(picture, reference));
}

void JumpFinder::add_gap(std::int64_t frame) {
    add_plane(frame, false, {});
}

void JumpFinder::add_plane(std::int64_t frame, bool repeat, Plane plane) {
    if (!(level_ > 0)) return;
    planes_.push_back(std::move(plane));
    if (planes_.size() > 3) planes_.pop_front();
    signals_.emplace_back();
    signals_.back().frame = frame;
    signals_.back().repeat = repeat;
    const std::size_t planes = planes_.size();
    if (planes >= 2 && !planes_[planes - 2].empty() && !planes_[planes - 1].empty()) {
        compare_with_before(signals_.back());
        if (planes == 3 && !planes_[0].empty()) compare_with_both(signals_[signals_.size() - 2]);
    }
    // The neighbours' own signals need one frame more.
    while (signals_.size() > next_ + kReach + 1) judge_next();
}

std::vector<Jump> JumpFinder::finish() {
    while (next_ < signals_.size()) judge_next();
    std::ranges::stable_sort(jumps_, {}, &Jump::frame);
    return std::move(jumps_);
}

/// body(block, its pixels), blocks in parallel.
template <typename PerBlock>
void JumpFinder::for_blocks(const PerBlock& body) const {
    const auto row_of_blocks = static_cast<std::size_t>(columns_);
    parallel_for(row_of_blocks * static_cast<std::size_t>(rows_), row_of_blocks,
                 [&](std::size_t begin, std::size_t end) {
                     for (std::size_t block = begin; block < end; ++block) body(block, box_of(block));
                 });
}

/// body(block) for a block and those around it.
template <typename PerBlock>
void JumpFinder::for_neighbours(std::size_t block, const PerBlock& body) const {
    const int column = static_cast<int>(block) % columns_;
    const int row = static_cast<int>(block) / columns_;
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
            const int neighbour = y * columns_ + x;
            body(static_cast<std::size_t>(neighbour));
        }
    }
}

Box JumpFinder::box_of(std::size_t block) const {
    const int x = static_cast<int>(block % static_cast<std::size_t>(columns_)) * block_;
    const int y = static_cast<int>(block / static_cast<std::size_t>(columns_)) * block_;
    return {x, y, std::min(block_, width_ - x), std::min(block_, height_ - y)};
}

void JumpFinder::compare_with_before(Signals& signals) const {
    const Plane& before = planes_[planes_.size() - 2];
    const Plane& now = planes_[planes_.size() - 1];
    const auto blocks = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    signals.change.assign(blocks, 0);
    std::vector<double> sums(blocks), counts(blocks);
    for_blocks([&](std::size_t block, const Box& box) {
        Plane changes;
        double sum = 0;
        for (int y = box.y; y < box.y + box.height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
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

void JumpFinder::compare_with_both(Signals& signals) const {
    const Plane& before = planes_[0];
    const Plane& now = planes_[1];
    const Plane& after = planes_[2];
    const auto blocks = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    signals.lone.assign(blocks, 0);
    signals.offset.assign(blocks, 0);
    signals.bend.assign(blocks, 0);
    struct Sums {
        double before = 0, now = 0, after = 0, count = 0;
    };
    std::vector<Sums> sums(blocks);
    for_blocks([&](std::size_t block, const Box& box) {
        Plane lone;
        Sums& sum = sums[block];
        for (int y = box.y; y < box.y + box.height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
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
        signals.offset[block] = alone(mean(sum.before), mean(sum.now), mean(sum.after), kFloor);
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

void JumpFinder::judge_next() {
    judge_lone(next_);
    judge_step(next_);
    ++next_;
    if (next_ > kReach) {
        signals_.pop_front();
        --next_;
    }
}

/// Indices of the nearest signals to either side that hold the field and that no jump touches.
std::vector<std::size_t> JumpFinder::near(Field field, Touched touched) const {
    const bool two_sided = field == &Signals::bend;
    const auto usable = [&](std::size_t i) {
        if ((signals_[i].*field).empty() || signals_[i].alone) return false;
        if (field == &Signals::change && signals_[i].repeat) return false;  // it says nothing of motion
        if (i > 0 && signals_[i - 1].alone) return false;
        return !(two_sided && i + 1 < signals_.size() && signals_[i + 1].alone);
    };
    std::vector<std::size_t> found;
    for (std::size_t i = touched.first; i-- > 0 && i + kNear >= touched.first;) {
        if (usable(i)) found.push_back(i);
    }
    for (std::size_t i = touched.last + 1; i < signals_.size() && i <= touched.last + kNear; ++i) {
        if (usable(i)) found.push_back(i);
    }
    return found;
}

/// What is usual in a block (see the class).
double JumpFinder::usual(Field field, Touched touched, const std::vector<std::size_t>& nearest,
                         std::size_t block) const {
    std::vector<float> values;
    const std::size_t begin = touched.first > kReach ? touched.first - kReach : 0;
    const std::size_t end = std::min(signals_.size(), touched.last + kReach + 1);
    for (std::size_t i = begin; i < end; ++i) {
        if (i >= touched.first && i <= touched.last) continue;
        if (!(signals_[i].*field).empty()) values.push_back((signals_[i].*field)[block]);
    }
    float most = median_of(values);
    for (const std::size_t i : nearest) {
        for_neighbours(
            block, [&](std::size_t neighbour) { most = std::max(most, (signals_[i].*field)[neighbour]); });
    }
    return static_cast<double>(most);
}

std::vector<double> JumpFinder::values_of(Mean mean, Touched touched) const {
    std::vector<double> values;
    const std::size_t begin = touched.first > kReach ? touched.first - kReach : 0;
    const std::size_t end = std::min(signals_.size(), touched.last + kReach + 1);
    for (std::size_t i = begin; i < end; ++i) {
        if ((i < touched.first || i > touched.last) && signals_[i].*mean) {
            values.push_back(*(signals_[i].*mean));
        }
    }
    return values;
}

/// How far the frame's mean leaves what is usual, 1 at the threshold of a flash.
double JumpFinder::flash_score(std::size_t index) const {
    const Signals& signals = signals_[index];
    if (!signals.mean_offset) return 0;
    std::vector<double> bends = values_of(&Signals::mean_bend, {index - 1, index + 1});
    if (bends.empty()) return 0;
    return std::abs(*signals.mean_offset) / (kFlash * median_of(bends) + kFrameFloor);
}

/// The score of a block that shows something for one frame, 1 at the threshold.
double JumpFinder::lone_score(std::size_t index, std::size_t block,
                              const std::vector<std::size_t>& near_changes,
                              const std::vector<std::size_t>& near_bends) const {
    const Signals& signals = signals_[index];
    const auto lone = static_cast<double>(signals.lone[block]);
    const double offset = std::abs(static_cast<double>(signals.offset[block]));
    double score = 0;
    if (lone > kLone * kBlockFloor) {
        const double change = usual(&Signals::change, {index, index + 1}, near_changes, block);
        const float even = evenness(signals.change[block], signals_[index + 1].change[block], kFloor);
        score = lone * static_cast<double>(even) / (kLone * (change + kBlockFloor));
    }
    if (offset > kOffset * kBlockFloor) {
        const double bend = usual(&Signals::bend, {index - 1, index + 1}, near_bends, block);
        score = std::max(score, offset / (kOffset * (bend + kBlockFloor)));
    }
    return score;
}

/// The share of the frame's mean offset that some blocks and those around them make.
double JumpFinder::explained_share(std::size_t index, const std::vector<std::size_t>& blocks) const {
    const Signals& signals = signals_[index];
    std::vector<bool> counted(signals.offset.size());
    double sum = 0;
    for (const std::size_t block : blocks) {
        for_neighbours(block, [&](std::size_t neighbour) {
            if (counted[neighbour]) return;
            counted[neighbour] = true;
            const Box box = box_of(neighbour);
            sum += static_cast<double>(signals.offset[neighbour]) * box.width * box.height;
        });
    }
    const double total = *signals.mean_offset * width_ * height_;
    return total != 0 ? sum / total : 1;
}

/// Whether some blocks, marked with a score of at least 1, count: each by itself above `single`, else where a
/// neighbour is marked too.
std::vector<std::size_t> JumpFinder::grouped(const std::vector<double>& scores, double single) const {
    std::vector<std::size_t> blocks;
    for (std::size_t block = 0; block < scores.size(); ++block) {
        if (scores[block] < 1) continue;
        int marked = 0;
        for_neighbours(block, [&](std::size_t neighbour) { marked += scores[neighbour] >= 1 ? 1 : 0; });
        if (marked > 1 || scores[block] >= single) blocks.push_back(block);
    }
    return blocks;
}

/// Blocks of squares of two by two that are all marked.
std::vector<std::size_t> JumpFinder::squares(const std::vector<double>& scores) const {
    std::vector<bool> counted(scores.size());
    for (int row = 0; row + 1 < rows_; ++row) {
        for (int column = 0; column + 1 < columns_; ++column) {
            const int corner = row * columns_ + column;
            const auto first = static_cast<std::size_t>(corner);
            const std::size_t square[] = {first, first + 1, first + static_cast<std::size_t>(columns_),
                                          first + static_cast<std::size_t>(columns_) + 1};
            if (!std::ranges::all_of(square, [&](std::size_t block) { return scores[block] >= 1; })) continue;
            for (const std::size_t block : square) counted[block] = true;
        }
    }
    std::vector<std::size_t> blocks;
    for (std::size_t block = 0; block < scores.size(); ++block) {
        if (counted[block]) blocks.push_back(block);
    }
    return blocks;
}

/// The jump of the frame's marked blocks.
Jump JumpFinder::region_jump(Jump::Kind kind, std::int64_t frame, const std::vector<double>& scores,
                             const std::vector<std::size_t>& blocks) const {
    Jump jump{kind, frame, 0, {}};
    for (const std::size_t block : blocks) {
        jump.score = std::max(jump.score, scores[block]);
        jump.region = united(jump.region, box_of(block));
    }
    return jump;
}

/// What the frame shows alone, whatever its neighbours do.
std::optional<Jump> JumpFinder::find_lone(std::size_t index) const {
    const Signals& signals = signals_[index];
    if (signals.lone.empty()) return std::nullopt;
    const std::vector<std::size_t> near_bends = near(&Signals::bend, {index - 1, index + 1});
    const std::vector<std::size_t> near_changes = near(&Signals::change, {index, index + 1});
    if (near_bends.empty() || near_changes.empty()) return std::nullopt;
    std::vector<double> scores(signals.lone.size());
    for (std::size_t block = 0; block < scores.size(); ++block) {
        scores[block] = lone_score(index, block, near_changes, near_bends);
    }
    const std::vector<std::size_t> blocks = grouped(scores, kSingle);
    const double flash = flash_score(index);
    if (blocks.empty() && flash < 1) return std::nullopt;
    Jump jump = region_jump(Jump::Kind::pop, signals.frame, scores, blocks);
    const double share = static_cast<double>(blocks.size()) / static_cast<double>(scores.size());
    if (flash >= 1 && (share > kFewBlocks || explained_share(index, blocks) < 0.5)) {
        jump = {Jump::Kind::flash, signals.frame, std::max(jump.score, flash), {0, 0, width_, height_}};
    }
    return jump;
}

void JumpFinder::judge_lone(std::size_t index) {
    Signals& signals = signals_[index];
    const std::optional<Jump> jump = find_lone(index);
    if (!jump) return;
    // Between what is usual and a step into or out of the frame, motion by itself looks alone; what really is
    // changes the frame on both sides alike.
    const auto [less, more] = std::minmax({step_score(index), step_score(index + 1)});
    if (jump->kind == Jump::Kind::pop && more >= 1 && less < kUneven * more) return;
    // A much stronger jump beside it shows here too.
    if (index > 0 && signals_[index - 1].alone && jump->score < signals_[index - 1].alone_score / 2) return;
    if (index + 1 < signals_.size()) {
        const std::optional<Jump> next = find_lone(index + 1);
        if (next && jump->score < next->score / 2) return;
    }
    signals.alone = true;
    signals.alone_score = jump->score;
    jumps_.push_back(*jump);
}

/// How far the frame's mean change exceeds the usual one, 1 at the threshold of a step.
double JumpFinder::step_score(std::size_t index) const {
    if (index >= signals_.size() || !signals_[index].mean_change) return 0;
    std::vector<float> around;
    for (const std::size_t i : near(&Signals::change, {index, index})) {
        around.push_back(static_cast<float>(*signals_[i].mean_change));
    }
    if (around.size() < 2) return 0;
    return *signals_[index].mean_change / (kStep * static_cast<double>(second_largest(around)) + kFrameFloor);
}

void JumpFinder::judge_step(std::size_t index) {
    const Signals& signals = signals_[index];
    // A frame that shows alone explains the change into it and out of it; after a repeat two steps come at
    // once.
    if (!signals.mean_change || signals.alone) return;
    if (index > 0 && (signals_[index - 1].alone || signals_[index - 1].repeat)) return;
    const Touched changes{index, index};
    const std::vector<std::size_t> nearest = near(&Signals::change, changes);
    if (nearest.size() < 2) return;
    const double score = step_score(index);
    if (score >= 1) {
        jumps_.push_back({Jump::Kind::step, signals.frame, score, {0, 0, width_, height_}});
        return;
    }
    std::vector<double> scores(signals.change.size());
    for (std::size_t block = 0; block < scores.size(); ++block) {
        const auto change = static_cast<double>(signals.change[block]);
        if (change < kRegionStep * kBlockFloor) continue;
        scores[block] =
            change / (kRegionStep * (usual(&Signals::change, changes, nearest, block) + kBlockFloor));
    }
    const std::vector<std::size_t> blocks = squares(scores);
    if (blocks.empty()) return;
    jumps_.push_back(region_jump(Jump::Kind::region_step, signals.frame, scores, blocks));
}

}  // namespace dapple::judge
