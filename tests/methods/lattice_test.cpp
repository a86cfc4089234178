#include "methods/photon_splatting/lattice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "methods/photon_splatting/kernel.h"

namespace dapple::methods {
namespace {

float cross(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

TEST(Lattice, ReducesToAShortBasisOfTheSameLattice) {
    for (int k = 0; k < 200; ++k) {
        const float angle = 0.1f * static_cast<float>(k);
        const glm::vec2 e1(std::cos(angle), std::sin(angle)), e2(-0.3f * e1.y, 0.3f * e1.x);
        const glm::vec2 first = 7.0f * e1 + 3.0f * e2,
                        second = 9.0f * e1 + 4.0f * e2;  // determinant 28 - 27 = 1
        const ReducedLattice lattice = reduce_lattice(first, second, glm::mat2(1));
        float weight = 0;
        for (int b = 0; b < lattice.count; ++b) {
            const LatticeBasis& basis = lattice.bases[static_cast<std::size_t>(b)];
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
        EXPECT_NEAR(glm::length(lattice.bases[0].first), 0.3f, 1e-5f);
        EXPECT_NEAR(glm::length(lattice.bases[0].second), 1, 1e-5f);
    }
}

TEST(Lattice, SharesPassSmoothlyFromOneBasisToTheOther) {
    // Skews on both sides of the tie: the share of the kernel on {(1, 0), (skew, 2)} against {(1, 0), (skew -
    // 1, 2)}.
    double last = 1;
    for (double skew = 0.2; skew < 0.8; skew += 0.001) {
        const ReducedLattice lattice = reduce_lattice({1, 0}, {static_cast<float>(skew), 2}, glm::mat2(1));
        double share = 0;
        for (int b = 0; b < lattice.count; ++b) {
            const LatticeBasis& basis = lattice.bases[static_cast<std::size_t>(b)];
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
    KernelMetric metric;
    metric.pixel_from_plane = glm::mat2(100);  // a pixel is a centimetre
    const LatticeBasis basis{{0.05f, 0}, {0, 0.03f}, 1};
    for (const KernelShape shape : {KernelShape::tent, KernelShape::box})
        for (const float scale : {0.3f, 1.0f, 1.7f, 2.0f})
            for (const float disc : {0.0f, 0.04f}) {
                metric.disc_radius = disc;
                const PlaneKernel kernel = widened_kernel(basis, metric, {shape, scale});
                const auto variance = [&](float extent, float box) {
                    const float core = extent * (1 - box), half = extent * box;
                    return core * core / (shape == KernelShape::tent ? 6 : 3) + half * half / 3;
                };
                const auto expected = [&](float spacing) {
                    const float side = scale * spacing;
                    // Tents that sum to one by themselves are not widened by pixels beyond two of them.
                    const bool pixel = shape == KernelShape::box || scale != std::round(scale);
                    return side * side / (shape == KernelShape::tent ? 6 : 12) + disc * disc / 4 +
                           (pixel ? 1e-4f / 12 : 0);
                };
                EXPECT_NEAR(variance(kernel.first.x, kernel.box_first), expected(0.05f),
                            1e-5f * expected(0.05f));
                EXPECT_NEAR(variance(kernel.second.y, kernel.box_second), expected(0.03f),
                            1e-5f * expected(0.03f));
            }
}

TEST(Lattice, CollapsedLatticesGiveFiniteKernelsOfAPixel) {
    KernelMetric metric;
    metric.pixel_from_plane = glm::mat2(100);  // a pixel is a centimetre
    const glm::vec2 cases[][2] = {{{0, 0}, {0, 0}},
                                  {{0.02f, 0}, {0, 0}},
                                  {{0.02f, 0.01f}, {0.02f, 0.01f}},
                                  {{0.02f, 0.01f}, {0.06f, 0.03f}},
                                  {{1e-12f, 0}, {3e-12f, 1e-20f}},
                                  {{0.02f, 0.01f}, {0.02f, 0.010000001f}}};
    for (const auto& vectors : cases)
        for (const float disc : {0.0f, 0.007f}) {
            metric.disc_radius = disc;
            const ReducedLattice lattice = reduce_lattice(vectors[0], vectors[1], reduction_metric(metric));
            for (int b = 0; b < lattice.count; ++b) {
                const PlaneKernel kernel = widened_kernel(lattice.bases[static_cast<std::size_t>(b)], metric);
                const float area = std::abs(cross(kernel.first, kernel.second));
                EXPECT_GT(area, 0.2f * 0.01f * 0.01f);  // half-extents of half a pixel: a quarter of its area
                EXPECT_TRUE(std::isfinite(area));
                EXPECT_LT(kernel.box_first, 1);
                EXPECT_LT(kernel.box_second, 1);
            }
        }
}

TEST(Lattice, TheDiscAddsItsVariance) {
    KernelMetric metric;
    metric.pixel_from_plane = glm::mat2(1e5);  // tiny pixels: they widen nothing
    metric.disc_radius = 0.03f;
    const PlaneKernel kernel = widened_kernel({{0.01f, 0}, {0, 0.02f}, 1}, metric);
    const auto variance = [](float extent, float box) {  // tent: h^2 / 6; box: h^2 / 3
        const float tent = extent * (1 - box), wide = extent * box;
        return tent * tent / 6 + wide * wide / 3;
    };
    EXPECT_NEAR(variance(kernel.first.x, kernel.box_first), 0.01 * 0.01 / 6 + 0.03 * 0.03 / 4, 1e-8);
    EXPECT_NEAR(variance(kernel.second.y, kernel.box_second), 0.02 * 0.02 / 6 + 0.03 * 0.03 / 4, 1e-8);
}

}  // namespace
}  // namespace dapple::methods
