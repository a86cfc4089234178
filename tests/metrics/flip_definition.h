#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "metrics/picture.h"

/// FLIP straight from the definition (Andersson et al. 2020), pixel by pixel in double, with kernels over the
/// plane: slow, and sharing nothing with what it tests.
namespace dapple::metrics::flip_definition {

struct Triple {
    double a = 0, b = 0, c = 0;
};

inline constexpr double kPi = 3.14159265358979323846;

inline Triple xyz_from_linear(Triple rgb) {
    // IEC 61966-2-1 from the chromaticities of Rec.709 and D65, to nine digits.
    return {0.412386564 * rgb.a + 0.357591496 * rgb.b + 0.180450485 * rgb.c,
            0.212636822 * rgb.a + 0.715182981 * rgb.b + 0.072180197 * rgb.c,
            0.019330620 * rgb.a + 0.119197164 * rgb.b + 0.950372561 * rgb.c};
}

inline Triple linear_from_xyz(Triple xyz) {
    return {3.241003275 * xyz.a - 1.537398934 * xyz.b - 0.498615861 * xyz.c,
            -0.969224334 * xyz.a + 1.875930071 * xyz.b + 0.041554224 * xyz.c,
            0.055639423 * xyz.a - 0.204011202 * xyz.b + 1.057148933 * xyz.c};
}

inline constexpr Triple kWhite{0.950428545, 1, 1.088900371};

inline Triple ycxcz_from_linear(Triple rgb) {
    const Triple xyz = xyz_from_linear(rgb);
    const double x = xyz.a / kWhite.a, y = xyz.b / kWhite.b, z = xyz.c / kWhite.c;
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

inline Triple linear_from_ycxcz(Triple colour) {
    const double y = (colour.a + 16) / 116, x = y + colour.b / 500, z = y - colour.c / 200;
    return linear_from_xyz({x * kWhite.a, y * kWhite.b, z * kWhite.c});
}

inline Triple hunt_lab(Triple rgb) {
    const Triple xyz = xyz_from_linear(rgb);
    const auto f = [](double t) {
        return t > std::pow(6.0 / 29, 3) ? std::cbrt(t) : t / (3 * 36.0 / 841) + 4.0 / 29;
    };
    const double x = f(xyz.a / kWhite.a), y = f(xyz.b / kWhite.b), z = f(xyz.c / kWhite.c);
    const double l = 116 * y - 16;
    return {l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}

inline double hyab(Triple p, Triple q) {
    return std::abs(p.a - q.a) + std::hypot(p.b - q.b, p.c - q.c);
}

/// Colour difference of two linear colours that fill both pictures: no filter changes them.
inline double colour_error(Triple p, Triple q) {
    const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7);
    const double difference = std::pow(hyab(hunt_lab(p), hunt_lab(q)), 0.7);
    if (difference < 0.4 * largest) return 0.95 / (0.4 * largest) * difference;
    return 0.95 + 0.05 * (difference - 0.4 * largest) / (0.6 * largest);
}

inline double linear_from_srgb(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

inline double tone(double x) {
    return std::fmin(1,
                     (0.36 * 2.51 * x * x + 0.6 * 0.03 * x) / (0.36 * 2.43 * x * x + 0.6 * 0.59 * x + 0.14));
}

/// Weights over the plane, (2 radius + 1)^2.
struct Kernel {
    int radius = 0;
    std::vector<double> weights;

    Kernel(int r, const std::function<double(double x, double y)>& weight) : radius(r) {
        for (int y = -r; y <= r; ++y) {
            for (int x = -r; x <= r; ++x) weights.push_back(weight(x, y));
        }
    }
    /// Positive weights sum to 1, negative ones to -1.
    Kernel& normalise() {
        double positive = 0, negative = 0;
        for (const double w : weights) (w > 0 ? positive : negative) += std::abs(w);
        for (double& w : weights) w /= w > 0 ? positive : negative;
        return *this;
    }
    /// Of values(x, y), the picture's edge repeated.
    double apply(int width, int height, int x, int y,
                 const std::function<double(int x, int y)>& values) const {
        double sum = 0;
        std::size_t i = 0;
        for (int dy = -radius; dy <= radius; ++dy) {
            for (int dx = -radius; dx <= radius; ++dx) {
                const int px = std::min(width - 1, std::max(0, x + dx));
                const int py = std::min(height - 1, std::max(0, y + dy));
                sum += weights[i++] * values(px, py);
            }
        }
        return sum;
    }
};

/// FLIP of each pixel of two pictures of linear colours in [0, 1].
inline std::vector<double> map(int width, int height, const std::vector<Triple>& picture,
                               const std::vector<Triple>& reference, double ppd) {
    const int blur = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * ppd));
    const auto sensitivity = [&](double a1, double b1, double a2, double b2) {
        return Kernel(blur,
                      [=](double x, double y) {
                          const double d = (x * x + y * y) / (ppd * ppd);
                          return a1 * std::sqrt(kPi / b1) * std::exp(-kPi * kPi * d / b1) +
                                 a2 * std::sqrt(kPi / b2) * std::exp(-kPi * kPi * d / b2);
                      })
            .normalise();
    };
    const Kernel csf[3] = {sensitivity(1, 0.0047, 0, 1), sensitivity(1, 0.0053, 0, 1),
                           sensitivity(34.1, 0.04, 13.5, 0.025)};
    const double sigma = 0.5 * 0.082 * ppd;
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    const auto gauss = [sigma](double x, double y) {
        return std::exp(-(x * x + y * y) / (2 * sigma * sigma));
    };
    const auto first = [&](double x, double y) { return -x * gauss(x, y); };
    const auto second = [&](double x, double y) { return (x * x / (sigma * sigma) - 1) * gauss(x, y); };
    const Kernel edge_x = Kernel(reach, first).normalise();
    const Kernel edge_y = Kernel(reach, [&](double x, double y) { return first(y, x); }).normalise();
    const Kernel point_x = Kernel(reach, second).normalise();
    const Kernel point_y = Kernel(reach, [&](double x, double y) { return second(y, x); }).normalise();

    struct Seen {
        Triple colour;
        double edge = 0, point = 0;
    };
    const auto see = [&](const std::vector<Triple>& linear, int x, int y) {
        const auto at = [&](int px, int py) {
            return ycxcz_from_linear(linear[static_cast<std::size_t>(py * width + px)]);
        };
        const auto filter = [&](const Kernel& kernel, double Triple::*channel) {
            return kernel.apply(width, height, x, y, [&](int px, int py) { return at(px, py).*channel; });
        };
        const auto feature = [&](const Kernel& kernel) {
            return kernel.apply(width, height, x, y,
                                [&](int px, int py) { return (at(px, py).a + 16) / 116; });
        };
        Triple rgb = linear_from_ycxcz(
            {filter(csf[0], &Triple::a), filter(csf[1], &Triple::b), filter(csf[2], &Triple::c)});
        for (double* value : {&rgb.a, &rgb.b, &rgb.c}) *value = std::fmin(1, std::fmax(0, *value));
        return Seen{rgb, std::hypot(feature(edge_x), feature(edge_y)),
                    std::hypot(feature(point_x), feature(point_y))};
    };
    std::vector<double> flip;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Seen p = see(picture, x, y), r = see(reference, x, y);
            const double feature = std::fmax(std::abs(p.edge - r.edge), std::abs(p.point - r.point));
            flip.push_back(
                std::pow(colour_error(p.colour, r.colour), 1 - std::sqrt(feature / std::sqrt(2.0))));
        }
    }
    return flip;
}

/// Of pictures of sRGB code values in [0, 1].
inline std::vector<double> ldr_map(const Picture& picture, const Picture& reference, double ppd) {
    const auto linear = [](const Picture& p) {
        std::vector<Triple> colours;
        for (std::size_t i = 0; i < p.pixels(); ++i) {
            colours.push_back({linear_from_srgb(static_cast<double>(p.rgb[0][i])),
                               linear_from_srgb(static_cast<double>(p.rgb[1][i])),
                               linear_from_srgb(static_cast<double>(p.rgb[2][i]))});
        }
        return colours;
    };
    return map(picture.width, picture.height, linear(picture), linear(reference), ppd);
}

/// Of linear pictures at one exposure.
inline std::vector<double> exposed_map(const Picture& picture, const Picture& reference, double exposure,
                                       double ppd) {
    const auto linear = [&](const Picture& p) {
        std::vector<Triple> colours;
        const auto value = [&](std::size_t c, std::size_t i) {
            return tone(std::fmax(0, static_cast<double>(p.rgb[c][i])) * std::exp2(exposure));
        };
        for (std::size_t i = 0; i < p.pixels(); ++i)
            colours.push_back({value(0, i), value(1, i), value(2, i)});
        return colours;
    };
    return map(picture.width, picture.height, linear(picture), linear(reference), ppd);
}

}  // namespace dapple::metrics::flip_definition
