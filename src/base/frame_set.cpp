#include "base/frame_set.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <optional>

#include "base/error.h"

namespace dapple {
namespace {

struct Item {
    std::int64_t first = 0;
    std::int64_t last = 0;
    std::uint64_t step = 1;
    bool inverse = false;

    std::uint64_t distance() const {
        // Unsigned arithmetic is right even where the signed difference would overflow.
        const auto a = static_cast<std::uint64_t>(first);
        const auto b = static_cast<std::uint64_t>(last);
        return first <= last ? b - a : a - b;
    }
    /// Saturates at the top instead of wrapping to 0 for the range of all 64-bit numbers.
    std::uint64_t count() const {
        const std::uint64_t steps = distance() / step;
        if (inverse) return distance() - steps;
        return steps == UINT64_MAX ? steps : steps + 1;
    }
};

[[noreturn]] void fail(std::string_view text, const std::string& reason) {
    throw Error(ExitCode::usage, "frames '" + clipped(std::string(text.substr(0, 100))) + "': " + reason);
}

[[noreturn]] void fail_too_many(std::string_view text) {
    fail(text, "more than " + std::to_string(FrameSet::kLargest) + " frames; ask for smaller ranges");
}

/// Reads one item of a frame set from left to right.
class ItemReader {
public:
    ItemReader(std::string_view item, std::string_view whole) : rest_(item), whole_(whole) {}

    Item read() {
        Item item;
        item.first = item.last = number("a frame number is expected");
        if (rest_.empty()) return item;
        if (!skip("..") && !skip("-")) fail_at_rest();
        item.last = number("the end of a range is expected, as in 1-10");
        if (rest_.empty()) return item;
        item.inverse = rest_.front() == 'y';
        if (!skip("x") && !skip("y")) fail_at_rest();
        item.step = step();
        if (!rest_.empty()) fail_at_rest();
        return item;
    }

private:
    bool skip(std::string_view token) {
        if (!rest_.starts_with(token)) return false;
        rest_.remove_prefix(token.size());
        return true;
    }

    std::int64_t number(const char* expected) {
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
        if (error == std::errc::result_out_of_range) fail(whole_, "a number does not fit into 64 bits");
        if (error != std::errc()) {
            if (!rest_.empty()) fail_at_rest();
            fail(whole_, std::string(expected) + "; write lists like 1,5,10-20x2");
        }
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return value;
    }

    std::uint64_t step() {
        const std::int64_t value = number("a step is expected after x or y, as in 1-10x2");
        if (value <= 0) fail(whole_, "a step must be positive; a descending range is written 10-1x2");
        return static_cast<std::uint64_t>(value);
    }

    [[noreturn]] void fail_at_rest() {
        if (rest_.front() == ':') {
            fail(whole_,
                 "':' means a step in some programs and a stagger in others; write 1-10x2 for every second "
                 "frame");
        }
        fail(whole_,
             "'" + clipped(std::string(rest_.substr(0, 20))) +
                 "' is not understood; write lists like 1,5,10-20x2 (every second) or 10-20y2 (the others)");
    }

    std::string_view rest_;
    std::string_view whole_;
};

std::string_view trimmed(std::string_view text) {
    constexpr const char* space = " \t";
    const std::size_t begin = text.find_first_not_of(space);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(space) - begin + 1);
}

void append(std::vector<std::int64_t>& frames, const Item& item) {
    const bool rising = item.first <= item.last;
    const std::uint64_t stride = item.inverse ? 1 : item.step;
    for (std::uint64_t at = 0;; at += stride) {
        if (!item.inverse || at % item.step != 0) {
            const auto first = static_cast<std::uint64_t>(item.first);
            frames.push_back(static_cast<std::int64_t>(rising ? first + at : first - at));
        }
        if (item.distance() - at < stride) break;
    }
}

/// Keeps the first of equal frames, in the order given; returns how many were dropped.
std::size_t drop_duplicates(std::vector<std::int64_t>& frames) {
    std::vector<std::uint32_t> order(frames.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return frames[a] < frames[b]; });
    std::vector<bool> repeated(frames.size(), false);
    for (std::size_t i = 1; i < order.size(); ++i) {
        repeated[order[i]] = frames[order[i]] == frames[order[i - 1]];
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (!repeated[i]) frames[kept++] = frames[i];
    }
    const std::size_t dropped = frames.size() - kept;
    frames.resize(kept);
    return dropped;
}

}  // namespace

FrameSet FrameSet::parse(std::string_view text) {
    std::vector<Item> items;
    std::uint64_t total = 0;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t comma = std::min(text.find(',', begin), text.size());
        const Item item = ItemReader(trimmed(text.substr(begin, comma - begin)), text).read();
        if (item.count() > kLargest || total + item.count() > kLargest) fail_too_many(text);
        // An inverse selects few frames only where its step is small, so walking it is bounded by its count
        // too: of a range of d frames at least d/2 are others, but for step 1, where none is.
        if (item.inverse && item.step == 1) fail(text, "y1 leaves no frame");
        total += item.count();
        items.push_back(item);
        begin = comma + 1;
    }
    FrameSet set;
    set.frames_.reserve(total);
    for (const Item& item : items) append(set.frames_, item);
    if (items.size() > 1) set.duplicates_ = drop_duplicates(set.frames_);
    if (set.frames_.empty()) fail(text, "no frame is selected");
    return set;
}

FrameSet FrameSet::range(std::int64_t first, std::int64_t last) {
    return parse(std::to_string(first) + "-" + std::to_string(last));
}

std::string to_string(const FrameSet& set) {
    const std::vector<std::int64_t>& frames = set.frames();
    std::string text;
    for (std::size_t i = 0; i < frames.size();) {
        // The longest run from i whose neighbours differ by one step; two frames are a run only if they
        // touch.
        std::size_t end = i + 1;
        const auto difference = [&](std::size_t k) {
            return static_cast<std::uint64_t>(frames[k]) - static_cast<std::uint64_t>(frames[k - 1]);
        };
        while (end < frames.size() && difference(end) == difference(i + 1)) ++end;
        std::uint64_t step = 1;
        if (end - i > 1) {
            const bool rising = frames[i] < frames[i + 1];
            step = rising ? difference(i + 1) : 0 - difference(i + 1);
            const bool plain_pair = end - i == 2 && step > 1;
            const bool too_wide = step > static_cast<std::uint64_t>(INT64_MAX);
            if (plain_pair || too_wide) end = i + 1;
        }
        if (!text.empty()) text += ',';
        text += std::to_string(frames[i]);
        if (end - i > 1) {
            text += '-' + std::to_string(frames[end - 1]);
            if (step > 1) text += 'x' + std::to_string(step);
        }
        i = end;
    }
    return text;
}

}  // namespace dapple
