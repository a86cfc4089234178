#include "metrics/flip_rows.h"

#include <algorithm>
#include <cmath>

#include "metrics/lane_math.h"

namespace dapple::metrics {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// Linear Rec.709 to XYZ over the white of (1, 1, 1): the chromaticities of ITU-R BT.709 and D65 as ratios of
/// whole numbers, each row divided by its sum.
constexpr Matrix kWhiteXyzFromRgb = [] {
    Matrix matrix{{{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                   {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                   {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}}};
    for (std::array<double, 3>& row : matrix) {
        const double white = row[0] + row[1] + row[2];
        for (double& element : row) element /= white;
    }
    return matrix;
}();

constexpr Matrix inverse(const Matrix& m) {
    Matrix result{};
    double determinant = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            result[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
        determinant += i == 0 ? m[0][0] * result[0][0] + m[0][1] * result[1][0] + m[0][2] * result[2][0] : 0;
    }
    for (std::array<double, 3>& row : result) {
        for (double& element : row) element /= determinant;
    }
    return result;
}

constexpr Matrix kRgbFromWhiteXyz = inverse(kWhiteXyzFromRgb);

struct Colour {
    Floats x, y, z;
};

Floats dot(const std::array<double, 3>& row, const Colour& colour) {
    return fma(all(static_cast<float>(row[0])), colour.x,
               fma(all(static_cast<float>(row[1])), colour.y, all(static_cast<float>(row[2])) * colour.z));
}

Colour product(const Matrix& matrix, const Colour& colour) {
    return {dot(matrix[0], colour), dot(matrix[1], colour), dot(matrix[2], colour)};
}

/// IEC 61966-2-1.
Floats linear_from_srgb(Floats code) {
    code = held(code, 0, 1);
    const Floats curve = power((code + all(0.055f)) * all(1 / 1.055f), all(2.4f));
    return where_greater(code, all(0.04045f), curve, code * all(1 / 12.92f));
}

/// The fit to ACES that HDR-FLIP uses (Narkowicz 2015, its exposure of 0.6 taken in), held to [0, 1].
Floats tone_mapped(Floats x) {
    // From 1e9 on the curve is above 1, and its terms are yet far from overflow.
    x = held(x, 0, 1e9f);
    const Floats above = x * fma(x, all(0.6f * 0.6f * 2.51f), all(0.6f * 0.03f));
    const Floats below = fma(x, fma(x, all(0.6f * 0.6f * 2.43f), all(0.6f * 0.59f)), all(0.14f));
    return minimum(above / below, all(1));
}

/// CIELAB's compression of X / X_n.
Floats compressed(Floats t) {
    constexpr float kDelta = 6.0f / 29;
    const Floats line = fma(t, all(1 / (3 * kDelta * kDelta)), all(4.0f / 29));
    return where_greater(t, all(kDelta * kDelta * kDelta), cube_root(maximum(t, all(FLT_MIN))), line);
}

std::size_t padded(std::size_t count) {
    return (count + kFloatLanes - 1) / kFloatLanes * kFloatLanes;
}

/// First `count` of eight floats, the last repeated.
Floats load_some(const float* values, std::size_t count) {
    if (count >= kFloatLanes) return load(values);
    float lanes[kFloatLanes];
    for (std::size_t i = 0; i < kFloatLanes; ++i) lanes[i] = values[std::min(i, count - 1)];
    return load(lanes);
}

/// Sum over distances k of weights[k] times the values at both sides.
Floats symmetric_sum(const float* values, const std::vector<float>& weights) {
    Floats total = all(weights[0]) * load(values);
    for (std::size_t k = 1; k < weights.size(); ++k) {
        total = fma(all(weights[k]), load(values - k) + load(values + k), total);
    }
    return total;
}

Floats symmetric_sum(const float* const* rows, std::size_t x, const std::vector<float>& weights) {
    Floats total = all(weights[0]) * load(rows[0] + x);
    for (std::size_t k = 1; k < weights.size(); ++k) {
        const auto step = static_cast<std::ptrdiff_t>(k);
        total = fma(all(weights[k]), load(rows[-step] + x) + load(rows[step] + x), total);
    }
    return total;
}

}  // namespace

FlipRows::FlipRows(const Picture& picture, const FlipKernels& kernels, const FlipTile& tile)
    : picture_(picture),
      kernels_(kernels),
      tile_(tile),
      width_(tile.right - tile.left),
      padded_width_(width_ + 2 * kernels.radius) {
    // Vectors that begin at the last column may reach beyond it by one less than their width, on both steps.
    const std::size_t room = padded(padded_width_) + 2 * kFloatLanes;
    const std::size_t rows = 2 * kernels.radius + 1;
    ring_.fill(std::vector<std::vector<float>>(rows, std::vector<float>(room)));
    sources_.fill(std::vector<const float*>(rows));
    columns_.fill(std::vector<float>(room));
    values_.fill(std::vector<float>(room));
}

void FlipRows::start(std::optional<double> exposure) {
    gain_ = exposure ? static_cast<float>(std::exp2(*exposure)) : 0;
    row_ = tile_.top;
    converted_ = tile_.top - std::min(tile_.top, kernels_.radius);
}

void FlipRows::advance() {
    const std::size_t last = static_cast<std::size_t>(picture_.height) - 1, radius = kernels_.radius;
    for (; converted_ <= std::min(last, row_ + radius); ++converted_) convert(converted_);
    for (std::size_t opponent = 0; opponent < kOpponents; ++opponent) {
        for (std::size_t i = 0; i < sources_[opponent].size(); ++i) {
            // Beyond the picture its outermost row is repeated.
            const std::size_t y = std::min(last, row_ + i - std::min(row_ + i, radius));
            sources_[opponent][i] = ring_[opponent][y % ring_[opponent].size()].data();
        }
    }
    filter_down();
    filter_across();
    to_lab();
    ++row_;
}

void FlipRows::convert(std::size_t y) {
    const std::size_t width = static_cast<std::size_t>(picture_.width), radius = kernels_.radius;
    const std::size_t left = tile_.left - std::min(tile_.left, radius);
    const std::size_t right = std::min(width, tile_.right + radius);
    const std::size_t before = left + radius - tile_.left;  // columns beyond the picture's left edge
    float* out[kOpponents];
    for (std::size_t i = 0; i < kOpponents; ++i) out[i] = ring_[i][y % ring_[i].size()].data() + before;
    for (std::size_t x = left; x < right; x += kFloatLanes) {
        const std::size_t at = y * width + x, count = right - x;
        Colour rgb{load_some(picture_.rgb[0].data() + at, count),
                   load_some(picture_.rgb[1].data() + at, count),
                   load_some(picture_.rgb[2].data() + at, count)};
        for (Floats* channel : {&rgb.x, &rgb.y, &rgb.z}) {
            *channel = gain_ > 0 ? tone_mapped(*channel * all(gain_)) : linear_from_srgb(*channel);
        }
        const Colour xyz = product(kWhiteXyzFromRgb, rgb);
        store(out[kY] + (x - left), xyz.y);
        store(out[kCx] + (x - left), xyz.x - xyz.y);
        store(out[kCz] + (x - left), xyz.y - xyz.z);
    }
    // Beyond the picture its outermost column is repeated.
    for (float* row : out) {
        std::fill(row - before, row, row[0]);
        std::fill(row + (right - left), row - before + padded(padded_width_) + kFloatLanes,
                  row[right - left - 1]);
    }
}

void FlipRows::filter_down() {
    const float* const* const y_rows = rows(kY);
    const float* const* const cx_rows = rows(kCx);
    const float* const* const cz_rows = rows(kCz);
    const std::vector<float>& luminance = kernels_.luminance;
    const std::vector<float>& gaussian = kernels_.gaussian;
    for (std::size_t x = 0; x < padded_width_; x += kFloatLanes) {
        store(columns_[kLuminance].data() + x, symmetric_sum(y_rows, x, luminance));
        store(columns_[kRedGreen].data() + x, symmetric_sum(cx_rows, x, kernels_.red_green));
    }
    for (std::size_t x = 0; x < padded_width_; x += kFloatLanes) {
        const Floats centre = load(y_rows[0] + x);
        Floats smooth = all(gaussian[0]) * centre, edges = all(0), points = all(0);
        for (std::size_t k = 1; k < gaussian.size(); ++k) {
            const auto step = static_cast<std::ptrdiff_t>(k);
            const Floats above = load(y_rows[-step] + x), below = load(y_rows[step] + x);
            const Floats both = above + below;
            smooth = fma(all(gaussian[k]), both, smooth);
            edges = fma(all(kernels_.edge[k]), below - above, edges);
            // Differences to the centre: where the picture is flat no rounding passes for a point.
            points = fma(all(kernels_.point[k]), both - (centre + centre), points);
        }
        store(columns_[kGaussian].data() + x, smooth);
        store(columns_[kEdges].data() + x, edges);
        store(columns_[kPoints].data() + x, points);
    }
    for (std::size_t x = 0; x < padded_width_; x += kFloatLanes) {
        store(columns_[kWide].data() + x, symmetric_sum(cz_rows, x, kernels_.blue_yellow_wide));
        store(columns_[kNarrow].data() + x, symmetric_sum(cz_rows, x, kernels_.blue_yellow_narrow));
    }
}

void FlipRows::filter_across() {
    const std::size_t radius = kernels_.radius;
    const auto column = [&](Column which, std::size_t x) { return columns_[which].data() + radius + x; };
    for (std::size_t x = 0; x < width_; x += kFloatLanes) {
        store(values_[kLightness].data() + x, symmetric_sum(column(kLuminance, x), kernels_.luminance));
        store(values_[kGreenRed].data() + x, symmetric_sum(column(kRedGreen, x), kernels_.red_green));
        store(values_[kBlueYellow].data() + x,
              symmetric_sum(column(kWide, x), kernels_.blue_yellow_wide) +
                  symmetric_sum(column(kNarrow, x), kernels_.blue_yellow_narrow));
    }
    for (std::size_t x = 0; x < width_; x += kFloatLanes) {
        const float* const smooth = column(kGaussian, x);
        const Floats centre = load(smooth);
        Floats edges = all(0), points = all(0);
        for (std::size_t k = 1; k < kernels_.edge.size(); ++k) {
            const Floats before = load(smooth - k), after = load(smooth + k);
            edges = fma(all(kernels_.edge[k]), after - before, edges);
            points = fma(all(kernels_.point[k]), before + after - (centre + centre), points);
        }
        const Floats edges_down = symmetric_sum(column(kEdges, x), kernels_.gaussian);
        const Floats points_down = symmetric_sum(column(kPoints, x), kernels_.gaussian);
        store(values_[kEdge].data() + x, square_root(fma(edges, edges, edges_down * edges_down)));
        store(values_[kPoint].data() + x, square_root(fma(points, points, points_down * points_down)));
    }
}

void FlipRows::to_lab() {
    float* const lightness = values_[kLightness].data();
    float* const green_red = values_[kGreenRed].data();
    float* const blue_yellow = values_[kBlueYellow].data();
    for (std::size_t i = 0; i < width_; i += kFloatLanes) {
        const Floats y = load(lightness + i);
        Colour rgb = product(kRgbFromWhiteXyz, {y + load(green_red + i), y, y - load(blue_yellow + i)});
        for (Floats* channel : {&rgb.x, &rgb.y, &rgb.z}) *channel = held(*channel, 0, 1);
        Colour xyz = product(kWhiteXyzFromRgb, rgb);
        for (Floats* channel : {&xyz.x, &xyz.y, &xyz.z}) *channel = compressed(*channel);
        const Floats l = fma(xyz.y, all(116), all(-16));
        // Hunt: colours are more colourful where it is bright.
        store(lightness + i, l);
        store(green_red + i, all(0.01f * 500) * l * (xyz.x - xyz.y));
        store(blue_yellow + i, all(0.01f * 200) * l * (xyz.y - xyz.z));
    }
}

namespace {

/// HyAB distance of Hunt-adjusted green and blue, the largest of Rec.709, to the power of 0.7.
double largest_colour_difference() {
    struct Lab {
        double l, a, b;
    };
    const auto lab = [](std::size_t primary) {
        const auto f = [&](std::size_t axis) {
            const double t = kWhiteXyzFromRgb[axis][primary];
            return t > 216.0 / 24389 ? std::cbrt(t) : 841.0 / 108 * t + 4.0 / 29;
        };
        const double l = 116 * f(1) - 16;
        return Lab{l, 0.01 * l * 500 * (f(0) - f(1)), 0.01 * l * 200 * (f(1) - f(2))};
    };
    const Lab green = lab(1), blue = lab(2);
    return std::pow(std::abs(green.l - blue.l) + std::hypot(green.a - blue.a, green.b - blue.b), 0.7);
}

}  // namespace

void compare_rows(const FlipRows& picture, const FlipRows& reference, std::size_t count, float* out) {
    using enum FlipRows::Value;
    // Up to 0.4 of the largest difference maps to [0, 0.95], the rest to what is left to 1.
    static const double largest = largest_colour_difference();
    const Floats knee = all(static_cast<float>(0.4 * largest));
    const Floats slope = all(static_cast<float>(0.95 / (0.4 * largest)));
    const Floats upper_slope = all(static_cast<float>(0.05 / (0.6 * largest)));
    const auto difference = [&](FlipRows::Value value, std::size_t x) {
        return load(picture[value] + x) - load(reference[value] + x);
    };
    for (std::size_t x = 0; x < count; x += kFloatLanes) {
        const Floats a = difference(kGreenRed, x), b = difference(kBlueYellow, x);
        const Floats hyab = absolute(difference(kLightness, x)) + square_root(fma(a, a, b * b));
        const Floats raised = power(hyab, all(0.7f));
        const Floats colour =
            where_greater(knee, raised, raised * slope, fma(raised - knee, upper_slope, all(0.95f)));
        const Floats feature = maximum(absolute(difference(kEdge, x)), absolute(difference(kPoint, x)));
        const Floats weight = square_root(feature * all(0.70710678f));
        store(out + x, power(colour, maximum(all(1) - weight, all(0))));
    }
}

}  // namespace dapple::metrics
