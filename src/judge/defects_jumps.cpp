#include "judge/defects_jumps.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace dapple::judge {
namespace {

constexpr double kFewBlocks = 0.25;  // the share up to which blocks are a region, not the frame
constexpr double kUneven = 0.6;

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
    : grid_(width, height), has_light_(static_cast<float>(level) > 0), meter_(grid_, level) {}

void JumpFinder::add(std::int64_t frame, const metrics::Picture& picture, const metrics::Picture* reference) {
    if (has_light_) measure(frame, false, picture, reference);
}

void JumpFinder::add_repeat(std::int64_t frame, const metrics::Picture& picture,
                            const metrics::Picture* reference) {
    if (has_light_) measure(frame, true, picture, reference);
}

void JumpFinder::add_gap(std::int64_t frame) {
    if (!has_light_) return;
    signals_.emplace_back().frame = frame;
    meter_.add_gap();
    judge_ready();
}

void JumpFinder::measure(std::int64_t frame, bool repeat, const metrics::Picture& picture,
                         const metrics::Picture* reference) {
    Signals* const before = signals_.empty() ? nullptr : &signals_.back();
    Signals& signals = signals_.emplace_back();
    signals.frame = frame;
    signals.repeat = repeat;
    meter_.add(picture, reference, signals, before);
    judge_ready();
}

void JumpFinder::judge_ready() {
    // The neighbours' own signals need one frame more.
    while (signals_.size() > next_ + kReach + 1) judge_next();
}

std::vector<Jump> JumpFinder::finish() {
    while (next_ < signals_.size()) judge_next();
    std::ranges::stable_sort(jumps_, {}, &Jump::frame);
    return std::move(jumps_);
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
        grid_.for_neighbours(
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

/// What the picture shows alone somewhere in each of the nearest frames, at most: their second largest.
double JumpFinder::alone_anywhere(Field field, const std::vector<std::size_t>& nearest) const {
    std::vector<float> most;
    for (const std::size_t i : nearest) {
        float of_frame = 0;
        for (const float value : signals_[i].*field) of_frame = std::max(of_frame, std::abs(value));
        most.push_back(of_frame);
    }
    return static_cast<double>(second_largest(most));
}

/// The score of a block that shows something for one frame, 1 at the threshold.
double JumpFinder::lone_score(std::size_t index, std::size_t block, const Around& around) const {
    const Signals& signals = signals_[index];
    const auto lone = static_cast<double>(signals.lone[block]);
    const double offset = std::abs(static_cast<double>(signals.offset[block]));
    const auto among = [](double value, double anywhere) {
        return value / (kAnywhere * (anywhere + kBlockFloor));
    };
    double score = 0;
    if (lone > kLone * kBlockFloor) {
        const double change = usual(&Signals::change, {index, index + 1}, around.changes, block);
        const float even = evenness(signals.change[block], signals_[index + 1].change[block],
                                    static_cast<float>(kBlockFloor));
        score = std::min(lone * static_cast<double>(even) / (kLone * (change + kBlockFloor)),
                         among(lone, around.lone));
    }
    if (offset > kOffset * kBlockFloor) {
        const double bend = usual(&Signals::bend, {index - 1, index + 1}, around.bends, block);
        score = std::max(score,
                         std::min(offset / (kOffset * (bend + kBlockFloor)), among(offset, around.offset)));
    }
    return score;
}

/// The share of the frame's mean offset that some blocks and those around them make.
double JumpFinder::explained_share(std::size_t index, const std::vector<std::size_t>& blocks) const {
    const Signals& signals = signals_[index];
    std::vector<bool> counted(signals.offset.size());
    double sum = 0;
    for (const std::size_t block : blocks) {
        grid_.for_neighbours(block, [&](std::size_t neighbour) {
            if (counted[neighbour]) return;
            counted[neighbour] = true;
            const Box box = grid_.box_of(neighbour);
            sum += static_cast<double>(signals.offset[neighbour]) * box.width * box.height;
        });
    }
    const double total = *signals.mean_offset * grid_.width * grid_.height;
    return total != 0 ? sum / total : 1;
}

/// Whether some blocks, marked with a score of at least 1, count: each by itself above `single`, else where a
/// neighbour is marked too.
std::vector<std::size_t> JumpFinder::grouped(const std::vector<double>& scores, double single) const {
    std::vector<std::size_t> blocks;
    for (std::size_t block = 0; block < scores.size(); ++block) {
        if (scores[block] < 1) continue;
        int marked = 0;
        grid_.for_neighbours(block, [&](std::size_t neighbour) { marked += scores[neighbour] >= 1 ? 1 : 0; });
        if (marked > 1 || scores[block] >= single) blocks.push_back(block);
    }
    return blocks;
}

/// Blocks of squares of two by two that are all marked.
std::vector<std::size_t> JumpFinder::squares(const std::vector<double>& scores) const {
    std::vector<bool> counted(scores.size());
    for (int row = 0; row + 1 < grid_.rows; ++row) {
        for (int column = 0; column + 1 < grid_.columns; ++column) {
            const int corner = row * grid_.columns + column;
            const auto first = static_cast<std::size_t>(corner);
            const std::size_t square[] = {first, first + 1, first + static_cast<std::size_t>(grid_.columns),
                                          first + static_cast<std::size_t>(grid_.columns) + 1};
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
        jump.region = united(jump.region, grid_.box_of(block));
    }
    return jump;
}

/// What the frame shows alone, whatever its neighbours do.
std::optional<Jump> JumpFinder::find_lone(std::size_t index) const {
    const Signals& signals = signals_[index];
    if (signals.lone.empty()) return std::nullopt;
    Around around;
    around.bends = near(&Signals::bend, {index - 1, index + 1});
    around.changes = near(&Signals::change, {index, index + 1});
    if (around.bends.empty() || around.changes.empty()) return std::nullopt;
    around.lone = alone_anywhere(&Signals::lone, around.bends);
    around.offset = alone_anywhere(&Signals::offset, around.bends);
    std::vector<double> scores(signals.lone.size());
    for (std::size_t block = 0; block < scores.size(); ++block) {
        scores[block] = lone_score(index, block, around);
    }
    const std::vector<std::size_t> blocks = grouped(scores, kSingle);
    const double flash = flash_score(index);
    if (blocks.empty() && flash < 1) return std::nullopt;
    Jump jump = region_jump(Jump::Kind::pop, signals.frame, scores, blocks);
    const double share = static_cast<double>(blocks.size()) / static_cast<double>(scores.size());
    if (flash >= 1 && (share > kFewBlocks || explained_share(index, blocks) < 0.5)) {
        jump = {
            Jump::Kind::flash, signals.frame, std::max(jump.score, flash), {0, 0, grid_.width, grid_.height}};
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
        jumps_.push_back({Jump::Kind::step, signals.frame, score, {0, 0, grid_.width, grid_.height}});
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
