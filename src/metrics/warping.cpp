#include "metrics/warping.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>

#include "metrics/counted.h"

namespace dapple::metrics {
namespace {

struct Sums {
    double squares = 0;
    std::size_t visible = 0;
    void operator+=(const Sums& other) {
        squares += other.squares;
        visible += other.visible;
    }
};

/// Four pixels of a picture and their weights.
struct Taps {
    std::size_t pixels[4];
    double weights[4];

    double sample(const std::vector<float>& plane) const {
        double value = 0;
        for (std::size_t i = 0; i < 4; ++i) value += weights[i] * static_cast<double>(plane[pixels[i]]);
        return value;
    }
};

class Warp {
public:
    Warp(const Picture& before, const Picture& frame, const Motion& motion)
        : before_(before), frame_(frame), motion_(motion) {
        if (before.excluded.empty()) return;
        unknown_.resize(before.pixels());
        for (const std::uint32_t pixel : before.excluded) unknown_[pixel] = 1;
    }

    void add_run(Sums& sums, std::size_t first, std::size_t last) const {
        const auto width = static_cast<std::size_t>(frame_.width);
        std::size_t x = first % width, y = first / width;
        for (std::size_t i = first; i < last; ++i) {
            if (const std::optional<Taps> taps = source_of(x, y, i)) {
                ++sums.visible;
                for (std::size_t c = 0; c < 3; ++c) {
                    const double difference =
                        static_cast<double>(frame_.rgb[c][i]) - taps->sample(before_.rgb[c]);
                    sums.squares += difference * difference;
                }
            }
            if (++x == width) {
                x = 0;
                ++y;
            }
        }
    }

private:
    /// Where the pixel comes from; nothing where it is not visible.
    std::optional<Taps> source_of(std::size_t x, std::size_t y, std::size_t i) const {
        const auto width = static_cast<std::size_t>(frame_.width);
        const auto height = static_cast<std::size_t>(frame_.height);
        const auto u = static_cast<double>(motion_.x[i]), v = static_cast<double>(motion_.y[i]);
        const double source_x = static_cast<double>(x) + u, source_y = static_cast<double>(y) + v;
        // Written so that what is not finite is outside.
        const bool inside = source_x >= 0 && source_x <= static_cast<double>(width - 1) && source_y >= 0 &&
                            source_y <= static_cast<double>(height - 1);
        if (!inside || !(gradient_square(x, y, i) <= 0.01 * (u * u + v * v) + 0.002)) return std::nullopt;
        const auto left = static_cast<std::size_t>(source_x), top = static_cast<std::size_t>(source_y);
        const double right_share = source_x - static_cast<double>(left);
        const double bottom_share = source_y - static_cast<double>(top);
        // Beyond the last column or row the weight is 0.
        const std::size_t across = left + 1 < width ? 1 : 0, down = top + 1 < height ? width : 0;
        const std::size_t corner = top * width + left;
        const Taps taps{{corner, corner + across, corner + down, corner + down + across},
                        {(1 - right_share) * (1 - bottom_share), right_share * (1 - bottom_share),
                         (1 - right_share) * bottom_share, right_share * bottom_share}};
        if (!unknown_.empty()) {
            for (std::size_t tap = 0; tap < 4; ++tap) {
                if (taps.weights[tap] != 0 && unknown_[taps.pixels[tap]] != 0) return std::nullopt;
            }
        }
        return taps;
    }

    double gradient_square(std::size_t x, std::size_t y, std::size_t i) const {
        const auto width = static_cast<std::size_t>(frame_.width);
        const auto height = static_cast<std::size_t>(frame_.height);
        const std::size_t left = x > 0 ? 1 : 0, right = x + 1 < width ? 1 : 0;
        const std::size_t up = y > 0 ? 1 : 0, down = y + 1 < height ? 1 : 0;
        const auto slope_square = [](const std::vector<float>& plane, std::size_t low, std::size_t high,
                                     std::size_t steps) {
            if (steps == 0) return 0.0;  // a picture one pixel wide
            const double slope = (static_cast<double>(plane[high]) - static_cast<double>(plane[low])) /
                                 static_cast<double>(steps);
            return slope * slope;
        };
        double sum = 0;
        for (const std::vector<float>* plane : {&motion_.x, &motion_.y}) {
            sum += slope_square(*plane, i - left, i + right, left + right);
            sum += slope_square(*plane, i - up * width, i + down * width, up + down);
        }
        return sum;
    }

    const Picture& before_;
    const Picture& frame_;
    const Motion& motion_;
    std::vector<std::uint8_t>
        unknown_;  ///< 1 where `before` excludes the pixel; empty where it excludes none
};

}  // namespace

WarpingError warping_error(const Picture& before, const Picture& frame, const Motion& motion) {
    assert(before.width == frame.width && before.height == frame.height);
    assert(motion.width == frame.width && motion.height == frame.height);
    const Warp warp(before, frame, motion);
    const auto sums = sum_counted<Sums>(
        frame.pixels(), frame.excluded,
        [&](Sums& tile, std::size_t first, std::size_t last) { warp.add_run(tile, first, last); });
    if (sums.visible == 0) return {};
    const auto visible = static_cast<double>(sums.visible);
    return {sums.squares / (3 * visible), visible / static_cast<double>(frame.pixels())};
}

}  // namespace dapple::metrics
