#include "metrics/flip_rows.h"

#include <algorithm>
#include <cmath>

#include "metrics/flip_filters.h"
#include "metrics/lane_math.h"

namespace dapple::metrics {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// Linear Rec.709 to XYZ over the white of (1, 1, 1): the chromaticities of ITU-R BT.709 and D65 as ratios of
/// whole numbers, each row over its sum.
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

/// By Cramer's rule.
constexpr Matrix inverse(const Matrix& m) {
    Matrix result{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            result[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    }
    const double determinant = m[0][0] * result[0][0] + m[0][1] * result[1][0] + m[0][2] * result[2][0];
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

Floats length(Floats x, Floats y) {
    return square_root(fma(x, x, y * y));
}

std::size_t padded(std::size_t count) {
    return (count + kFilterBlock - 1) / kFilterBlock * kFilterBlock;
}

/// First `count` of eight floats, the last repeated.
Floats load_some(const float* values, std::size_t count) {
    if (count >= kFloatLanes) return load(values);
    float lanes[kFloatLanes];
    for (std::size_t i = 0; i < kFloatLanes; ++i) lanes[i] = values[std::min(i, count - 1)];
    return load(lanes);
}

}  // namespace

FlipRows::FlipRows(const Picture& picture, const FlipKernels& kernels, const FlipTile& tile)
    : picture_(picture),
      kernels_(kernels),
      tile_(tile),
      width_(tile.right - tile.left),
      padded_width_(width_ + 2 * kernels.radius) {
    // Blocks that begin at the last column reach beyond it, both down and, from there, across.
    const std::size_t room = padded(width_) + 2 * kernels.radius + kFilterBlock;
    const std::size_t rows = 2 * kernels.radius + 1;
    ring_.fill(std::vector<std::vector<float>>(rows, std::vector<float>(room)));
    sources_.fill(std::vector<const float*>(rows));
    steps_.resize(rows);
    columns_.fill(std::vector<float>(room));
    across_.fill(std::vector<float>(room));
    values_.fill(std::vector<float>(room));
}

void FlipRows::start(std::optional<double> exposure) {
    gain_.reset();
    if (exposure) gain_ = static_cast<float>(std::exp2(*exposure));
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
    set_values();
    ++row_;
}

void FlipRows::convert(std::size_t y) {
    const std::size_t width = static_cast<std::size_t>(picture_.width), radius = kernels_.radius;
    const std::size_t left = tile_.left - std::min(tile_.left, radius);
    const std::size_t right = std::min(width, tile_.right + radius);
    const std::size_t before = left + radius - tile_.left;  // columns beyond the picture's left edge
    const std::size_t next = std::min(y + 1, static_cast<std::size_t>(picture_.height) - 1) * width;
    float* out[kOpponents];
    for (std::size_t i = 0; i < kOpponents; ++i) out[i] = ring_[i][y % ring_[i].size()].data() + before;
    for (std::size_t x = left; x < right; x += kFloatLanes) {
        const std::size_t at = y * width + x, count = right - x;
        Colour rgb{load_some(picture_.rgb[0].data() + at, count),
                   load_some(picture_.rgb[1].data() + at, count),
                   load_some(picture_.rgb[2].data() + at, count)};
        for (Floats* channel : {&rgb.x, &rgb.y, &rgb.z}) {
            *channel = gain_ ? tone_mapped(*channel * all(*gain_)) : linear_from_srgb(*channel);
        }
        // The next row begins far away in memory, where no processor looks by itself.
        for (const std::vector<float>& plane : picture_.rgb) {
            _mm_prefetch(plane.data() + next + x, _MM_HINT_T0);
        }
        const Colour xyz = product(kWhiteXyzFromRgb, rgb);
        store(out[kY] + (x - left), xyz.y);
        store(out[kCx] + (x - left), xyz.x - xyz.y);
        store(out[kCz] + (x - left), xyz.y - xyz.z);
    }
    // Beyond the picture its outermost column is repeated.
    for (float* row : out) {
        std::fill(row - before, row, row[0]);
        std::fill(row + (right - left), row - before + padded_width_, row[right - left - 1]);
    }
}

void FlipRows::filter_down() {
    const auto out = [&](Column column) { return columns_[column].data(); };
    const auto rows = [&](Opponent opponent) { return sources_[opponent].data() + kernels_.radius; };
    smooth_by_both(out(kLuminance), out(kGaussian), rows(kY), padded_width_, kernels_.luminance,
                   kernels_.gaussian);
    differentiate(out(kEdges), out(kPoints), rows(kY), padded_width_, kernels_.edge, kernels_.point);
    smooth(out(kRedGreen), rows(kCx), padded_width_, kernels_.red_green);
    smooth_by_both(out(kNarrow), out(kWide), rows(kCz), padded_width_, kernels_.blue_yellow_narrow,
                   kernels_.blue_yellow_wide);
}

void FlipRows::filter_across() {
    const auto out = [&](Filtered which) { return across_[which].data(); };
    const auto columns = [&](Column column) {
        for (std::size_t i = 0; i < steps_.size(); ++i) steps_[i] = columns_[column].data() + i;
        return steps_.data() + kernels_.radius;
    };
    smooth(out(kFilteredY), columns(kLuminance), width_, kernels_.luminance);
    smooth(out(kFilteredCx), columns(kRedGreen), width_, kernels_.red_green);
    smooth(out(kFilteredCzWide), columns(kWide), width_, kernels_.blue_yellow_wide);
    smooth(out(kFilteredCzNarrow), columns(kNarrow), width_, kernels_.blue_yellow_narrow);
    differentiate(out(kEdgeAcross), out(kPointAcross), columns(kGaussian), width_, kernels_.edge,
                  kernels_.point);
    smooth(out(kEdgeDown), columns(kEdges), width_, kernels_.gaussian);
    smooth(out(kPointDown), columns(kPoints), width_, kernels_.gaussian);
}

void FlipRows::set_values() {
    for (std::size_t x = 0; x < width_; x += kFloatLanes) {
        const auto in = [&](Filtered which) { return load(across_[which].data() + x); };
        const auto set = [&](Value value, Floats lanes) { store(values_[value].data() + x, lanes); };
        const Floats y = in(kFilteredY);
        Colour rgb = product(kRgbFromWhiteXyz,
                             {y + in(kFilteredCx), y, y - (in(kFilteredCzWide) + in(kFilteredCzNarrow))});
        for (Floats* channel : {&rgb.x, &rgb.y, &rgb.z}) *channel = held(*channel, 0, 1);
        Colour xyz = product(kWhiteXyzFromRgb, rgb);
        for (Floats* channel : {&xyz.x, &xyz.y, &xyz.z}) *channel = compressed(*channel);
        const Floats l = fma(xyz.y, all(116), all(-16));
        set(kLightness, l);
        // Hunt: the same chroma seems stronger where it is bright.
        set(kGreenRed, all(0.01f * 500) * l * (xyz.x - xyz.y));
        set(kBlueYellow, all(0.01f * 200) * l * (xyz.y - xyz.z));
        set(kEdge, length(in(kEdgeAcross), in(kEdgeDown)));
        set(kPoint, length(in(kPointAcross), in(kPointDown)));
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
        const Floats hyab = absolute(difference(kLightness, x)) + length(a, b);
        const Floats raised = power(hyab, all(0.7f));
        const Floats colour =
            where_greater(knee, raised, raised * slope, fma(raised - knee, upper_slope, all(0.95f)));
        const Floats feature = maximum(absolute(difference(kEdge, x)), absolute(difference(kPoint, x)));
        const Floats weight = square_root(feature * all(0.70710678f));
        store(out + x, power(colour, maximum(all(1) - weight, all(0))));
    }
}

}  // namespace dapple::metrics
