#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "judge/box.h"
#include "metrics/picture.h"

/// What is measured of a clip, frame by frame, to find its jumps.
namespace dapple::judge {

/// A picture cut into square blocks, so few that what is kept of a frame has a bound.
struct BlockGrid {
    BlockGrid(int width, int height);

    int width, height;        ///< pixels
    int side, columns, rows;  ///< pixels of a block, but for the last; blocks

    std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
    Box box_of(std::size_t block) const;

    /// body(block) for a block and those around it.
    template <typename PerBlock>
    void for_neighbours(std::size_t block, const PerBlock& body) const {
        const int column = static_cast<int>(block) % columns;
        const int row = static_cast<int>(block) / columns;
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
            for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns - 1); ++x) {
                const int neighbour = y * columns + x;
                body(static_cast<std::size_t>(neighbour));
            }
        }
    }
};

inline constexpr double kBlockFloor = 0.005;  ///< of v: added to what is usual in a block
inline constexpr double kFrameFloor = 0.002;  ///< and in a frame

/// Of a frame of luminance I, taken as v = I / (I + m), m the clip's level: bounded, so that a glint counts
/// as one pixel, and without a unit; with a reference as v_I - v_R, in which the motion common to both is
/// gone. Vectors have a value a block, x being a block's mean of v, and are empty where a neighbour in time
/// is not there; so are the means over the frame. A pixel that moves on smoothly lies between its neighbours
/// in time, so `lone` and `offset` are near 0 however fast water moves, and are not where something shows for
/// one frame.
struct BlockSignals {
    std::optional<double> mean_change;             ///< mean of |v_t - v_(t-1)|
    std::vector<float> change;                     ///< median over pixels of |v_t - v_(t-1)|
    std::optional<double> mean_offset, mean_bend;  ///< `offset` and `bend` of the frame's mean
    std::vector<float> lone;    ///< median over pixels of |v_t - median(v_(t-1), v_t, v_(t+1))|
    std::vector<float> offset;  ///< x_t - median(x_(t-1), x_t, x_(t+1)), times evenness()
    std::vector<float> bend;    ///< |x_t - (x_(t-1) + x_(t+1)) / 2|
};

/// Measures frame after frame; keeps three.
class SignalMeter {
public:
    SignalMeter(const BlockGrid& grid, double level);

    /// The next frame. Fills of it what needs the frame before, and of that, `before`, what needs both of its
    /// neighbours; null for the first.
    void add(const metrics::Picture& picture, const metrics::Picture* reference, BlockSignals& signals,
             BlockSignals* before);
    /// The next frame cannot be had.
    void add_gap();

private:
    using Plane = std::vector<float>;
    Plane plane_of(const metrics::Picture& picture, const metrics::Picture* reference) const;
    void add_plane(Plane plane);
    void compare_with_before(BlockSignals& signals) const;
    void compare_with_both(BlockSignals& signals) const;

    BlockGrid grid_;
    float level_;
    std::deque<Plane> planes_;  ///< v of the last three frames, the newest last; an empty one is a gap
};

/// Where a frame differs from one neighbour far more than from the other, it is the other side of something
/// that happens to that neighbour, or between the two; where it differs from both alike, it is alone: 1.
inline float evenness(float a, float b, float floor) {
    const float more = std::max(a, b);
    return more > 0 ? std::min(1.0f, (2 * std::min(a, b) + floor) / more) : 1.0f;
}

/// Upper median; 0 of nothing. Reorders.
template <typename T>
T median_of(std::vector<T>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

}  // namespace dapple::judge
