#include "metrics/ssim.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "base/parallel.h"
#include "metrics/lanes.h"

namespace dapple::metrics {
namespace {

constexpr std::size_t kTileRows = 32;  ///< rows of windows
constexpr std::size_t kGaussianSize = 11;
constexpr double kGaussianSigma = 1.5;
constexpr std::size_t kBoxSize = 8;
constexpr std::size_t kBoxStride = 4;

/// Where windows stand: at (column, row) * stride, `width` x `height` pixels each.
struct WindowGrid {
    std::size_t width, height, stride, columns, rows;

    WindowGrid(const Picture& picture, std::size_t size, std::size_t step)
        : width(std::min(size, static_cast<std::size_t>(picture.width))),
          height(std::min(size, static_cast<std::size_t>(picture.height))),
          stride(step),
          columns((static_cast<std::size_t>(picture.width) - width) / stride + 1),
          rows((static_cast<std::size_t>(picture.height) - height) / stride + 1) {}
};

/// The four sums that SSIM is made of, one value a column.
enum : std::size_t { kPicture, kReference, kSquares, kProduct, kSums };  // kSquares: of both together

/// `count` values of each sum; rows are padded so that whole vectors may be read and written.
class SumRows {
public:
    static constexpr std::size_t kStep = 4 * kDoubleLanes;

    explicit SumRows(std::size_t count)
        : pitch_((count + kStep - 1) / kStep * kStep + kStep), values_(kSums * pitch_) {}
    double* operator[](std::size_t sum) { return values_.data() + sum * pitch_; }

private:
    std::size_t pitch_;
    std::vector<double> values_;
};

void set_pixels(SumRows& sums, const float* picture, const float* reference, std::size_t count) {
    double* const p = sums[kPicture];
    double* const r = sums[kReference];
    double* const squares = sums[kSquares];
    double* const product = sums[kProduct];
    for (std::size_t x = 0; x < count; x += kDoubleLanes) {
        const Doubles a = load_doubles(picture + x, count - x), b = load_doubles(reference + x, count - x);
        store(p + x, a);
        store(r + x, b);
        store(squares + x, a * a + b * b);
        store(product + x, a * b);
    }
}

/// out[x] = sum over t of weights[t] * sources[t][x], for symmetric weights.
void filter(double* out, const std::array<const double*, kGaussianSize>& sources,
            const std::vector<double>& weights, std::size_t count) {
    const std::size_t taps = weights.size();
    for (std::size_t x = 0; x < count; x += SumRows::kStep) {
        Doubles sums[4] = {};
        for (std::size_t t = 0; t < taps / 2; ++t) {
            for (std::size_t i = 0; i < 4; ++i) {
                sums[i] += weights[t] * (load(sources[t] + x + i * kDoubleLanes) +
                                         load(sources[taps - 1 - t] + x + i * kDoubleLanes));
            }
        }
        for (std::size_t i = 0; i < 4; ++i) {
            if (taps % 2 == 1) sums[i] += weights[taps / 2] * load(sources[taps / 2] + x + i * kDoubleLanes);
            store(out + x + i * kDoubleLanes, sums[i]);
        }
    }
}

/// Weights of sum 1.
std::vector<double> gaussian(std::size_t size) {
    std::vector<double> weights(size);
    double total = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const double x = static_cast<double>(i) - 0.5 * static_cast<double>(size - 1);
        weights[i] = std::exp(-x * x / (2 * kGaussianSigma * kGaussianSigma));
        total += weights[i];
    }
    for (double& weight : weights) weight /= total;
    return weights;
}

/// SSIM of luminance under Gaussian windows, by one tile's rows from top to bottom.
class GaussianRows {
public:
    GaussianRows(const Picture& picture, const Picture& reference, const WindowGrid& grid, double peak)
        : picture_(picture),
          reference_(reference),
          grid_(grid),
          across_(gaussian(grid.width)),
          down_(gaussian(grid.height)),
          c1_(0.01 * 0.01 * peak * peak),
          c2_(0.03 * 0.03 * peak * peak),
          pixels_(static_cast<std::size_t>(picture.width)),
          filtered_(grid.height, SumRows(grid.columns)),
          means_(grid.columns) {}

    /// Of row `row` of windows; rows of a tile follow one another.
    void row(std::size_t row, double* values) {
        // A ring of rows filtered across: the tile's first window needs all of its own, a later one adds one.
        for (std::size_t y = std::max(row, next_); y < row + grid_.height; ++y) filter_across(y);
        next_ = row + grid_.height;
        for (std::size_t sum = 0; sum < kSums; ++sum) {
            std::array<const double*, kGaussianSize> sources{};
            for (std::size_t t = 0; t < grid_.height; ++t) {
                sources[t] = filtered_[(row + t) % grid_.height][sum];
            }
            filter(means_[sum], sources, down_, grid_.columns);
        }
        const double* const a = means_[kPicture];
        const double* const b = means_[kReference];
        const double* const squares = means_[kSquares];
        const double* const product = means_[kProduct];
        for (std::size_t x = 0; x < grid_.columns; ++x) {
            const double both = a[x] * b[x], each = a[x] * a[x] + b[x] * b[x];
            const double covariance = product[x] - both, variances = squares[x] - each;
            values[x] = (2 * both + c1_) * (2 * covariance + c2_) / ((each + c1_) * (variances + c2_));
        }
    }

private:
    void filter_across(std::size_t y) {
        const std::size_t width = static_cast<std::size_t>(picture_.width);
        set_pixels(pixels_, picture_.luminance.data() + y * width, reference_.luminance.data() + y * width,
                   width);
        SumRows& out = filtered_[y % grid_.height];
        for (std::size_t sum = 0; sum < kSums; ++sum) {
            std::array<const double*, kGaussianSize> sources{};
            for (std::size_t t = 0; t < grid_.width; ++t) sources[t] = pixels_[sum] + t;
            filter(out[sum], sources, across_, grid_.columns);
        }
    }

    const Picture& picture_;
    const Picture& reference_;
    const WindowGrid& grid_;
    std::vector<double> across_, down_;
    double c1_, c2_;
    SumRows pixels_;
    std::vector<SumRows> filtered_;
    SumRows means_;
    std::size_t next_ = 0;  ///< row of pixels that is not yet filtered
};

/// SSIM of unweighted boxes, the mean over R, G and B.
class BoxRows {
public:
    BoxRows(const Picture& picture, const Picture& reference, const WindowGrid& grid, double peak)
        : picture_(picture),
          reference_(reference),
          grid_(grid),
          c1_(416.0 / (64 * 64) / (255.0 * 255) * peak * peak),
          c2_(235963.0 / (64 * 63) / (255.0 * 255) * peak * peak),
          columns_(static_cast<std::size_t>(picture.width)) {}

    void row(std::size_t row, double* values) {
        std::fill_n(values, grid_.columns, 0);
        for (std::size_t channel = 0; channel < 3; ++channel) {
            sum_columns(channel, row * grid_.stride);
            for (std::size_t column = 0; column < grid_.columns; ++column) {
                values[column] += value(column * grid_.stride) / 3;
            }
        }
    }

private:
    /// Sums down the rows of the windows.
    void sum_columns(std::size_t channel, std::size_t first) {
        const std::size_t width = static_cast<std::size_t>(picture_.width);
        const float* const picture = picture_.rgb[channel].data() + first * width;
        const float* const reference = reference_.rgb[channel].data() + first * width;
        for (std::size_t x = 0; x < width; x += kDoubleLanes) {
            Doubles a{}, b{}, squares{}, product{};
            for (std::size_t y = 0; y < grid_.height; ++y) {
                const Doubles p = load_doubles(picture + y * width + x, width - x);
                const Doubles r = load_doubles(reference + y * width + x, width - x);
                a += p;
                b += r;
                squares += p * p + r * r;
                product += p * r;
            }
            store(columns_[kPicture] + x, a);
            store(columns_[kReference] + x, b);
            store(columns_[kSquares] + x, squares);
            store(columns_[kProduct] + x, product);
        }
    }

    double value(std::size_t x) {
        std::array<double, kSums> sums{};
        for (std::size_t sum = 0; sum < kSums; ++sum) {
            const double* const columns = columns_[sum] + x;
            for (std::size_t i = 0; i < grid_.width; ++i) sums[sum] += columns[i];
        }
        const double n = static_cast<double>(grid_.width * grid_.height), free = std::max(n - 1, 1.0);
        const double a = sums[kPicture] / n, b = sums[kReference] / n;
        const double variances = (sums[kSquares] - n * (a * a + b * b)) / free;
        const double covariance = (sums[kProduct] - n * a * b) / free;
        return (2 * a * b + c1_) * (2 * covariance + c2_) / ((a * a + b * b + c1_) * (variances + c2_));
    }

    const Picture& picture_;
    const Picture& reference_;
    const WindowGrid& grid_;
    double c1_,
        c2_;  ///< ffmpeg's integers for 8-bit values; its C1 is smaller than (0.01 L)^2 by a factor of 64
    SumRows columns_;
};

/// Windows that hold an excluded pixel, row by row; empty where there is none.
std::vector<std::uint8_t> excluded_windows(const Picture& picture, const WindowGrid& grid) {
    if (picture.excluded.empty()) return {};
    std::vector<std::uint8_t> windows(grid.columns * grid.rows);
    const auto first = [&](std::size_t pixel, std::size_t size) {
        return pixel < size ? 0 : (pixel - size) / grid.stride + 1;
    };
    const std::size_t width = static_cast<std::size_t>(picture.width);
    for (const std::uint32_t pixel : picture.excluded) {
        const std::size_t x = pixel % width, y = pixel / width;
        const std::size_t left = first(x, grid.width), right = std::min(grid.columns, x / grid.stride + 1);
        const std::size_t bottom = std::min(grid.rows, y / grid.stride + 1);
        for (std::size_t row = first(y, grid.height); row < bottom && left < right; ++row) {
            std::fill_n(windows.begin() + static_cast<std::ptrdiff_t>(row * grid.columns + left),
                        right - left, std::uint8_t{1});
        }
    }
    return windows;
}

/// Index of the window whose centre is the nearest to a pixel's.
std::size_t nearest_window(std::size_t pixel, std::size_t size, std::size_t stride, std::size_t count) {
    // Centres of windows lie at index * stride + size / 2, those of pixels at + 1/2; in halves of a pixel.
    const std::size_t position = 2 * pixel + 1 + stride;
    return position < size ? 0 : std::min(count - 1, (position - size) / (2 * stride));
}

template <class Rows>
double mean_ssim(const Picture& picture, const Picture& reference, const WindowGrid& grid, double peak,
                 std::vector<float>* map) {
    struct Sum {
        double total = 0;
        std::size_t windows = 0;
    };
    const std::vector<std::uint8_t> excluded = excluded_windows(reference, grid);
    std::vector<Sum> sums((grid.rows + kTileRows - 1) / kTileRows);
    std::vector<float> windows(map != nullptr ? grid.columns * grid.rows : 0);
    parallel_for(grid.rows, kTileRows, [&](std::size_t begin, std::size_t end) {
        Rows rows(picture, reference, grid, peak);
        std::vector<double> values(grid.columns);
        Sum sum;
        for (std::size_t row = begin; row < end; ++row) {
            rows.row(row, values.data());
            for (std::size_t column = 0; column < grid.columns; ++column) {
                if (!excluded.empty() && excluded[row * grid.columns + column] != 0) continue;
                sum.total += values[column];
                ++sum.windows;
            }
            if (map != nullptr) {
                std::ranges::transform(values,
                                       windows.begin() + static_cast<std::ptrdiff_t>(row * grid.columns),
                                       [](double value) { return static_cast<float>(value); });
            }
        }
        sums[begin / kTileRows] = sum;
    });
    if (map != nullptr) {
        const std::size_t width = static_cast<std::size_t>(picture.width);
        map->resize(picture.pixels());
        for (std::size_t i = 0; i < map->size(); ++i) {
            const std::size_t row = nearest_window(i / width, grid.height, grid.stride, grid.rows);
            const std::size_t column = nearest_window(i % width, grid.width, grid.stride, grid.columns);
            (*map)[i] = windows[row * grid.columns + column];
        }
    }
    Sum total;
    for (const Sum& sum : sums) {
        total.total += sum.total;
        total.windows += sum.windows;
    }
    return total.windows > 0 ? total.total / static_cast<double>(total.windows) : 1;
}

}  // namespace

double ssim(const Picture& picture, const Picture& reference, const SsimOptions& options,
            std::vector<float>* map) {
    assert(picture.width == reference.width && picture.height == reference.height);
    assert(picture.excluded == reference.excluded);
    if (picture.pixels() == 0) return 1;
    if (options.window == SsimWindow::boxes) {
        const WindowGrid grid(picture, kBoxSize, kBoxStride);
        return mean_ssim<BoxRows>(picture, reference, grid, options.peak, map);
    }
    const WindowGrid grid(picture, kGaussianSize, 1);
    return mean_ssim<GaussianRows>(picture, reference, grid, options.peak, map);
}

}  // namespace dapple::metrics
