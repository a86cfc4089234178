#include "methods/photon_splatting/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "methods/photon_splatting/kernel.h"

namespace dapple::methods {
namespace {

float cross(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

Vectors2 all(glm::vec2 v) {
    return {methods::all(v.x), methods::all(v.y)};
}
glm::vec2 lane(Vectors2 v, std::size_t k) {
    return {v.x[k], v.y[k]};
}

struct Basis {
    glm::vec2 first, second;
    float weight;
};

/// In a lane, beside others; without those of no weight.
std::vector<Basis> reduced(glm::vec2 first, glm::vec2 second, const Metric& metric, std::size_t k = 3) {
    Vectors2 a = all({1, 0}), b = all({0.37f, 11});  // lanes take different numbers of steps
    a.x[k] = first.x;
    a.y[k] = first.y;
    b.x[k] = second.x;
    b.y[k] = second.y;
    std::vector<Basis> bases;
    for (const LatticeBasis& basis : reduce_lattice(a, b, metric))
        if (basis.weight[k] != 0)
            bases.push_back({lane(basis.first, k), lane(basis.second, k), basis.weight[k]});
    return bases;
}

struct Kernel {
    glm::vec2 first, second;
    float box_first, box_second;
};
Kernel widened(const Basis& basis, const KernelMetric& metric, const KernelStyle& style = {}) {
    const PlaneKernel kernel =
        widened_kernel({all(basis.first), all(basis.second), methods::all(1.0f)}, metric, style);
    return {lane(kernel.first, 5), lane(kernel.second, 5), kernel.box_first[5], kernel.box_second[5]};
}

KernelMetric metric_of(float pixels_a_metre, float disc_radius = 0) {
    KernelMetric metric;
    metric.cell_from_first = all({pixels_a_metre, 0});
    metric.cell_from_second = all({0, pixels_a_metre});
    metric.disc_radius = methods::all(disc_radius);
    return metric;
}

TEST(Lattice, ReducesToAShortBasisOfTheSameLattice) {
    for (int k = 0; k < 200; ++k) {
        const float angle = 0.1f * static_cast<float>(k);
        const glm::vec2 e1(std::cos(angle), std::sin(angle)), e2(-0.3f * e1.y, 0.3f * e1.x);
        const glm::vec2 first = 7.0f * e1 + 3.0f * e2,
                        second = 9.0f * e1 + 4.0f * e2;  // determinant 28 - 27 = 1
        const std::vector<Basis> lattice = reduced(first, second, {}, static_cast<std::size_t>(k) % 8);
        float weight = 0;
        for (const Basis& basis : lattice) {
            weight += basis.weight;
            // Area kept: 2^-24 times the terms of the products, of about 50.
            EXPECT_NEAR(std::abs(cross(basis.first, basis.second)), 0.3f, 2e-5f);
            // Integer coordinates in the given basis.
            for (const glm::vec2 v : {basis.first, basis.second}) {
                const float a = cross(v, second) / cross(first, second),
                            c = cross(first, v) / cross(first, second);
                EXPECT_NEAR(a, std::round(a), 1e-3f);
                EXPECT_NEAR(c, std::round(c), 1e-3f);
            }
        }
        EXPECT_FLOAT_EQ(weight, 1);
        EXPECT_NEAR(glm::length(lattice[0].first), 0.3f, 1e-5f);
        EXPECT_NEAR(glm::length(lattice[0].second), 1, 1e-5f);
    }
}

TEST(Lattice, SharesPassSmoothlyFromOneBasisToTheOther) {
    // Skews on both sides of the tie: the share of the kernel on {(1, 0), (skew, 2)} against {(1, 0), (skew -
    // 1, 2)}.
    double last = 1;
    for (double skew = 0.2; skew < 0.8; skew += 0.001) {
        double share = 0;
        for (const Basis& basis : reduced({1, 0}, {static_cast<float>(skew), 2}, {})) {
            const glm::vec2 v = std::abs(basis.first.y) > 1 ? basis.first : basis.second;
            if (v.x * v.y > 0) share += static_cast<double>(basis.weight);
        }
        EXPECT_LE(share, last + 1e-5);
        EXPECT_LT(last - share, 0.02);
        last = share;
    }
    EXPECT_NEAR(last, 0, 1e-6);
}

TEST(Lattice, KernelsOfAnyScaleHaveTheVariancesOfShapePixelAndDiscTogether) {
    const Basis basis{{0.05f, 0}, {0, 0.03f}, 1};
    for (const KernelShape shape : {KernelShape::tent, KernelShape::box})
        for (const float scale : {0.3f, 1.0f, 1.7f, 2.0f})
            for (const float disc : {0.0f, 0.04f}) {
                const KernelMetric metric = metric_of(100, disc);  // a pixel is a centimetre
                const Kernel kernel = widened(basis, metric, {shape, scale});
                const auto variance = [&](float extent, float box) {
                    const float core = extent * (1 - box), half = extent * box;
                    return core * core / (shape == KernelShape::tent ? 6.0f : 3.0f) + half * half / 3;
                };
                const auto expected = [&](float spacing) {
                    const float side = scale * spacing;
                    // Tents that sum to one by themselves are not widened by pixels beyond two of them.
                    const bool pixel = shape == KernelShape::box || scale != std::round(scale);
                    return side * side / (shape == KernelShape::tent ? 6.0f : 12.0f) + disc * disc / 4 +
                           (pixel ? 1e-4f / 12 : 0);
                };
                EXPECT_NEAR(variance(kernel.first.x, kernel.box_first), expected(0.05f),
                            1e-5f * expected(0.05f));
                EXPECT_NEAR(variance(kernel.second.y, kernel.box_second), expected(0.03f),
                            1e-5f * expected(0.03f));
            }
}

TEST(Lattice, CollapsedLatticesGiveFiniteKernelsOfAPixel) {
    const glm::vec2 cases[][2] = {{{0, 0}, {0, 0}},
                                  {{0.02f, 0}, {0, 0}},
                                  {{0.02f, 0.01f}, {0.02f, 0.01f}},
                                  {{0.02f, 0.01f}, {0.06f, 0.03f}},
                                  {{1e-12f, 0}, {3e-12f, 1e-20f}},
                                  {{0.02f, 0.01f}, {0.02f, 0.010000001f}}};
    for (const auto& vectors : cases)
        for (const float disc : {0.0f, 0.007f}) {
            const KernelMetric metric = metric_of(100, disc);  // a pixel is a centimetre
            for (const Basis& basis : reduced(vectors[0], vectors[1], reduction_metric(metric))) {
                const Kernel kernel = widened(basis, metric);
                const float area = std::abs(cross(kernel.first, kernel.second));
                EXPECT_GT(area, 0.2f * 0.01f * 0.01f);  // half-extents of half a pixel: a quarter of its area
                EXPECT_TRUE(std::isfinite(area));
                EXPECT_LT(kernel.box_first, 1);
                EXPECT_LT(kernel.box_second, 1);
            }
        }
}

TEST(Lattice, TheDiscAddsItsVariance) {
    const KernelMetric metric = metric_of(1e5, 0.03f);  // tiny pixels: they widen nothing
    const Kernel kernel = widened({{0.01f, 0}, {0, 0.02f}, 1}, metric);
    const auto variance = [](float extent, float box) {  // tent: h^2 / 6; box: h^2 / 3
        const float tent = extent * (1 - box), wide = extent * box;
        return tent * tent / 6 + wide * wide / 3;
    };
    EXPECT_NEAR(variance(kernel.first.x, kernel.box_first), 0.01 * 0.01 / 6 + 0.03 * 0.03 / 4, 1e-8);
    EXPECT_NEAR(variance(kernel.second.y, kernel.box_second), 0.02 * 0.02 / 6 + 0.03 * 0.03 / 4, 1e-8);
}

}  // namespace
}  // namespace dapple::methods
