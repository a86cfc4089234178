#include "judge/defects_shift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/parallel.h"

namespace dapple::judge {
namespace {

constexpr int kStride = 4;
constexpr int kSide = 2 * kMostShift + 1;
constexpr std::size_t kTilePixels = 1 << 14;
/// Of the mean square of v: what rounding and harmless noise make.
constexpr double kEqual = 1e-8;

std::vector<float> bounded(const metrics::Picture& picture, double level) {
    const auto scale = static_cast<float>(level);
    std::vector<float> values(picture.pixels());
    parallel_for(values.size(), kTilePixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float luminance = picture.luminance[i];
            values[i] = luminance > 0 ? luminance / (luminance + scale) : 0;
        }
    });
    return values;
}

/// The pixels that stay inside the picture for every shift.
struct Field {
    int width, height;
    const std::vector<float>& picture;
    const std::vector<float>& reference;

    double mean_square(int dx, int dy) const {
        double sum = 0;
        std::size_t count = 0;
        for (int y = kMostShift; y < height - kMostShift; y += kStride) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
            const std::size_t shifted = static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(width);
            for (int x = kMostShift; x < width - kMostShift; x += kStride) {
                const float d = picture[shifted + static_cast<std::size_t>(x + dx)] -
                                reference[row + static_cast<std::size_t>(x)];
                sum += static_cast<double>(d * d);
                ++count;
            }
        }
        return count > 0 ? sum / static_cast<double>(count) : 0;
    }
};

/// Where the parabola through three neighbouring values has its minimum, in (-0.5, 0.5).
double vertex(double before, double at, double after) {
    const double bend = before - 2 * at + after;
    return bend > 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

}  // namespace

std::optional<Shift> find_shift(const metrics::Picture& picture, const metrics::Picture& reference,
                                double level) {
    const std::vector<float> values = bounded(picture, level);
    const std::vector<float> expected = bounded(reference, level);
    const Field field{picture.width, picture.height, values, expected};
    const double here = field.mean_square(0, 0);
    // Where no neighbour fits better, no place further off is looked for: a pattern's mean square grows from
    // its own place on.
    bool better = false;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        better = better || field.mean_square(dx, dy) < here;
    }
    if (!better || here < kEqual) return std::nullopt;

    std::vector<double> squares(kSide * kSide);
    parallel_for(squares.size(), kSide, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            squares[i] = field.mean_square(static_cast<int>(i) % kSide - kMostShift,
                                           static_cast<int>(i) / kSide - kMostShift);
        }
    });
    const auto best = static_cast<int>(std::ranges::min_element(squares) - squares.begin());
    const int column = best % kSide;
    const int row = best / kSide;
    const auto at = [&](int x, int y) { return squares[static_cast<std::size_t>(y * kSide + x)]; };
    if ((column == kMostShift && row == kMostShift) || !(at(column, row) < kGain * here)) return std::nullopt;
    Shift shift{static_cast<double>(column - kMostShift), static_cast<double>(row - kMostShift)};
    if (column > 0 && column < kSide - 1) {
        shift.dx += vertex(at(column - 1, row), at(column, row), at(column + 1, row));
    }
    if (row > 0 && row < kSide - 1) {
        shift.dy += vertex(at(column, row - 1), at(column, row), at(column, row + 1));
    }
    return shift;
}

}  // namespace dapple::judge
