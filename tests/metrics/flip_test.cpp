#include "metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "metrics/flip_definition.h"
#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

using namespace testing_pictures;

double linear(float code) {
    return flip_definition::linear_from_srgb(static_cast<double>(code));
}

/// What two pictures of one colour each must have, everywhere.
double expected(glm::vec3 a, glm::vec3 b) {
    return flip_definition::colour_error({linear(a.r), linear(a.g), linear(a.b)},
                                         {linear(b.r), linear(b.g), linear(b.b)});
}

/// All pixels against the definition. Ours computes in float, where colours of equal pictures' parts may come
/// out up to 4e-5 apart (CIELAB's a is 500 times a difference of cube roots): 1e-5, except where all there is
/// is this difference, whose power of 0.7 is 0.95 / 16.5 (4e-5)^0.7 = 5e-5.
void expect_map(const Flip& flip, const std::vector<double>& definition) {
    ASSERT_EQ(flip.map.size(), definition.size());
    double sum = 0;
    for (std::size_t i = 0; i < definition.size(); ++i) {
        const double tolerance = definition[i] < 1e-3 ? 5e-5 : 1e-5;
        ASSERT_NEAR(static_cast<double>(flip.map[i]), definition[i], tolerance) << "pixel " << i;
        sum += definition[i];
    }
    EXPECT_NEAR(flip.mean, sum / static_cast<double>(definition.size()), 1e-5);
    EXPECT_NEAR(flip.largest, *std::ranges::max_element(definition), 1e-5);
}

TEST(Flip, OfEqualPicturesIsNone) {
    const Picture picture = eight_bit_scene(50, 40, 1, 0.4f);
    const Flip flip = flip_ldr(picture, picture);
    EXPECT_EQ(flip.mean, 0);
    EXPECT_EQ(flip.weighted_median, 0);
    EXPECT_EQ(flip.largest, 0);
    EXPECT_EQ(flip_hdr(picture, picture, {-2, 3, 4}).largest, 0);
}

TEST(Flip, OfBlackAndWhiteIsKnown) {
    // L* is 0 and 100 and there is no chroma: HyAB 100. Green and blue are at L* 87.735, a
    // (L*, a*, b*) = (87.735, -86.184, 83.181) and (32.297, 79.188, -107.862), chroma times L / 100:
    // (87.735, -75.613, 72.979) and (32.297, 25.575, -34.836): HyAB = 55.438 + hypot(101.188, 107.815) =
    // 203.300. 100^0.7 = 25.119 is above 0.4 * 203.300^0.7 = 16.510: 0.95 + 0.05 (25.119 - 16.510) / (41.276
    // - 16.510).
    const Flip flip = flip_ldr(constant(30, 30, {0, 0, 0}), constant(30, 30, {1, 1, 1}));
    EXPECT_NEAR(flip.mean, 0.96738, 1e-5);  // to the digits above
    EXPECT_NEAR(flip.largest, expected({0, 0, 0}, {1, 1, 1}), 1e-5);
    EXPECT_NEAR(flip.weighted_median, flip.mean, 1e-6);
}

TEST(Flip, OfConstantsIsTheirColourDifference) {
    const glm::vec3 pairs[][2] = {{{0.5f, 0.5f, 0.5f}, {0.52f, 0.52f, 0.52f}},
                                  {{0.02f, 0.02f, 0.02f}, {0.03f, 0.03f, 0.03f}},
                                  {{1, 0, 0}, {0, 1, 0}},
                                  {{0, 1, 0}, {0, 0, 1}},
                                  {{0.2f, 0.4f, 0.7f}, {0.25f, 0.38f, 0.6f}}};
    for (const auto& pair : pairs) {
        const Flip flip = flip_ldr(constant(27, 23, pair[0]), constant(27, 23, pair[1]));
        for (const float value : flip.map) EXPECT_NEAR(value, expected(pair[0], pair[1]), 1e-5);
    }
    // Green and blue are the farthest apart of all: 1.
    EXPECT_NEAR(flip_ldr(constant(8, 8, {0, 1, 0}), constant(8, 8, {0, 0, 1})).mean, 1, 1e-6);
}

TEST(Flip, HoldsCodeValuesToTheirRange) {
    EXPECT_EQ(flip_ldr(constant(9, 9, {-1, 2, 0.5f}), constant(9, 9, {0, 1, 0.5f})).mean, 0);
}

TEST(Flip, OfAnEdgeAgreesWithTheDefinition) {
    const Picture reference = constant(34, 29, {0.5f, 0.5f, 0.5f});
    const Picture edge = picture_by(34, 29, [](int x, int y) {
        return x + y / 3 < 20 ? glm::vec3(0.5f, 0.5f, 0.5f) : glm::vec3(0.9f, 0.6f, 0.3f);
    });
    expect_map(flip_ldr(edge, reference), flip_definition::ldr_map(edge, reference, kDefaultPixelsPerDegree));
}

TEST(Flip, OfAPointAgreesWithTheDefinition) {
    // At a corner and inside, so that the repeated border has its say.
    const Picture reference = constant(26, 25, {0.3f, 0.35f, 0.4f});
    const Picture point = picture_by(26, 25, [](int x, int y) {
        const bool there = (x == 14 && y == 11) || (x == 0 && y == 24);
        return there ? glm::vec3(1, 1, 0.9f) : glm::vec3(0.3f, 0.35f, 0.4f);
    });
    expect_map(flip_ldr(point, reference),
               flip_definition::ldr_map(point, reference, kDefaultPixelsPerDegree));
}

TEST(Flip, OfASceneAgreesWithTheDefinition) {
    // Smaller than the kernels in one direction; other pixels a degree, too.
    const Picture picture = eight_bit_scene(31, 8, 1, 0.5f), reference = eight_bit_scene(31, 8, 2, 0.2f);
    for (const double ppd : {kDefaultPixelsPerDegree, 25.0}) {
        expect_map(flip_ldr(picture, reference, ppd), flip_definition::ldr_map(picture, reference, ppd));
    }
}

TEST(Flip, DoesNotMindWhichOfBothIsTheReference) {
    const Picture a = eight_bit_scene(70, 50, 1, 0.5f), b = eight_bit_scene(70, 50, 2, 0.2f);
    EXPECT_EQ(flip_ldr(a, b).map, flip_ldr(b, a).map);
}

TEST(Flip, IsSeamlessAcrossTiles) {
    // A picture of several tiles, shifted: what was inside one is at the seam of others.
    const auto scene = [](int shift, std::uint64_t seed) {
        return picture_by(530, 400, [=](int x, int y) {
            const auto index = static_cast<std::uint64_t>((y + shift) * 1000 + x + shift);
            return glm::vec3(static_cast<float>(hash_uniform(seed, 0, index, 0)));
        });
    };
    const Flip flip = flip_ldr(scene(0, 1), scene(0, 2)), shifted = flip_ldr(scene(12, 1), scene(12, 2));
    for (std::size_t y = 30; y < 380; ++y) {
        for (std::size_t x = 30; x < 500; ++x) {
            ASSERT_EQ(flip.map[y * 530 + x], shifted.map[(y - 12) * 530 + x - 12]) << x << ", " << y;
        }
    }
}

TEST(Flip, HasTheSameBitsOnAnyNumberOfThreads) {
    const Picture a = eight_bit_scene(500, 260, 1, 0.5f), b = eight_bit_scene(500, 260, 2, 0.2f);
    set_thread_count(1);
    const Flip one = flip_ldr(a, b);
    set_thread_count(4);
    const Flip four = flip_ldr(a, b);
    set_thread_count(0);
    EXPECT_EQ(one.map, four.map);
    EXPECT_EQ(one.mean, four.mean);
    EXPECT_EQ(one.weighted_median, four.weighted_median);
}

TEST(Flip, GrowsWithTheDifference) {
    const Picture reference = constant(24, 24, {0.4f, 0.4f, 0.4f});
    double before = 0;
    for (const float step : {0.01f, 0.03f, 0.1f, 0.3f, 0.6f}) {
        const double mean = flip_ldr(constant(24, 24, glm::vec3(0.4f + step)), reference).mean;
        EXPECT_GT(mean, before);
        before = mean;
    }
}

TEST(Flip, WeighsItsMedian) {
    const Flip flip = flip_ldr(eight_bit_scene(60, 50, 1, 0.5f), eight_bit_scene(60, 50, 2, 0.1f));
    std::vector<float> sorted = flip.map;
    std::ranges::sort(sorted);
    double total = 0, sum = 0;
    for (const float value : sorted) total += static_cast<double>(value);
    const auto half = std::ranges::find_if(sorted, [&](float value) {
        sum += static_cast<double>(value);
        return sum >= total / 2;
    });
    EXPECT_EQ(static_cast<float>(flip.weighted_median), *half);
    EXPECT_GT(flip.weighted_median, flip.mean);
}

TEST(Flip, OfSeveralPairsIsThatOfEach) {
    const Picture a = eight_bit_scene(70, 30, 1, 0.5f), b = eight_bit_scene(70, 30, 2, 0.2f);
    const Picture c = eight_bit_scene(70, 30, 3, 0.1f);
    const std::vector<FlipPair> pairs{{&a, &b}, {&b, &c}, {&c, &a}, {&a, &a}};
    const std::vector<Flip> ldr = flips_ldr(pairs), hdr = flips_hdr(pairs, {-1, 1, 2});
    ASSERT_EQ(ldr.size(), 4u);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        EXPECT_EQ(ldr[i].map, flip_ldr(*pairs[i].picture, *pairs[i].reference).map) << i;
        EXPECT_EQ(hdr[i].map, flip_hdr(*pairs[i].picture, *pairs[i].reference, {-1, 1, 2}).map) << i;
        EXPECT_EQ(ldr[i].mean == 0, i == 3);
    }
    EXPECT_TRUE(flips_ldr({}).empty());
}

TEST(Flip, LeavesOutExcludedPixels) {
    // White against black in the upper half; of its two last rows, excluded, the map says 0 and the mean
    // knows nothing.
    Picture picture = picture_by(40, 40, [](int, int y) { return glm::vec3(y < 20 ? 1.0f : 0.0f); });
    Picture reference = constant(40, 40, {0, 0, 0});
    for (std::uint32_t pixel = 40 * 18; pixel < 40 * 20; ++pixel) {
        exclude(picture, pixel);
        exclude(reference, pixel);
    }
    const Flip flip = flip_ldr(picture, reference);
    // As black in both, which enters their neighbours' blur.
    const Picture shorter = picture_by(40, 40, [](int, int y) { return glm::vec3(y < 18 ? 1.0f : 0.0f); });
    std::vector<float> expected = flip_ldr(shorter, constant(40, 40, {0, 0, 0})).map;
    double sum = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const bool excluded = i >= 40 * 18 && i < 40 * 20;
        if (excluded) {
            EXPECT_GT(expected[i], 0.05f);  // or else there was nothing to leave out
            expected[i] = 0;
        }
        sum += static_cast<double>(expected[i]);
    }
    EXPECT_EQ(flip.map, expected);
    EXPECT_NEAR(flip.mean, sum / (1600 - 80), 1e-6);  // of rounding
}

TEST(HdrFlip, AgreesWithTheDefinition) {
    const auto scene = [](std::uint64_t seed) {
        return picture_by(25, 22, [=](int x, int y) {
            const auto index = static_cast<std::uint64_t>(y * 25 + x);
            const double bright = std::exp2(6 * hash_uniform(seed, 0, index, 0) - 4 + (x > 12 ? 3 : 0));
            return glm::vec3(static_cast<float>(bright), static_cast<float>(0.7 * bright),
                             0.2f * static_cast<float>(x % 3));
        });
    };
    const Picture picture = scene(1), reference = scene(2);
    std::vector<double> largest(picture.pixels());
    for (const double exposure : {-3.0, -0.5, 2.0}) {
        const std::vector<double> one =
            flip_definition::exposed_map(picture, reference, exposure, kDefaultPixelsPerDegree);
        std::ranges::transform(largest, one, largest.begin(),
                               [](double a, double b) { return std::fmax(a, b); });
    }
    expect_map(flip_hdr(picture, reference, {-3, 2, 3}), largest);
}

TEST(HdrFlip, OfOneExposureIsLdrFlipOfTheToneMapped) {
    const auto encoded = [](const Picture& picture) {
        return picture_by(picture.width, picture.height, [&](int x, int y) {
            glm::vec3 code;
            for (int c = 0; c < 3; ++c) {
                const float value =
                    picture.rgb[static_cast<std::size_t>(c)][static_cast<std::size_t>(y * picture.width + x)];
                const double t = flip_definition::tone(static_cast<double>(value));
                code[c] =
                    static_cast<float>(t <= 0.0031308 ? 12.92 * t : 1.055 * std::pow(t, 1 / 2.4) - 0.055);
            }
            return code;
        });
    };
    const Picture a = eight_bit_scene(40, 30, 1, 0.5f), b = eight_bit_scene(40, 30, 2, 0.2f);
    const Flip hdr = flip_hdr(a, b, {0, 0, 2}), ldr = flip_ldr(encoded(a), encoded(b));
    // The code values are rounded to float, and features amplify it.
    for (std::size_t i = 0; i < hdr.map.size(); ++i) EXPECT_NEAR(hdr.map[i], ldr.map[i], 1e-5);
    EXPECT_NEAR(hdr.mean, ldr.mean, 1e-6);
}

TEST(HdrFlip, SeesWhatOneExposureHides) {
    // Both are far above white at exposure 0: only short exposures tell them apart.
    const Picture a = constant(20, 20, {200, 200, 200}), b = constant(20, 20, {400, 400, 400});
    EXPECT_LT(flip_hdr(a, b, {0, 0, 2}).mean, 1e-6);
    EXPECT_GT(flip_hdr(a, b, {-8, 0, 3}).mean, 0.2);
}

TEST(HdrFlip, TakesNegativeAndHugeValues) {
    const Picture negative = constant(9, 9, {-5, -1e30f, -1}), black = constant(9, 9, {0, 0, 0});
    EXPECT_EQ(flip_hdr(negative, black, {-1, 4, 2}).largest, 0);
    EXPECT_EQ(flip_hdr(constant(9, 9, {1, 1, 1}), black, {-400, -300, 2}).largest, 0);
    const Picture huge = constant(9, 9, {3e38f, 3e38f, 3e38f}), bright = constant(9, 9, {1e6f, 1e6f, 1e6f});
    EXPECT_EQ(flip_hdr(huge, bright, {0, 4, 2}).largest, 0);
}

TEST(Exposures, PutMedianAndLargestWhereThePaperDoes) {
    // Two fifths of the pixels at 1/64, one at 1/4, two at 3.5: the median is 1/4.
    const Picture picture = picture_by(5, 4, [](int x, int) {
        return glm::vec3(x < 2 ? 1.0f / 64 : x == 2 ? 0.25f : 3.5f);
    });
    const Exposures exposures = exposures_of({&picture});
    // Both come to 0.85 of the tone curve; the weights of luminance sum to 1 but for their rounding to float.
    EXPECT_NEAR(flip_definition::tone(3.5 * std::exp2(exposures.start)), 0.85, 1e-6);
    EXPECT_NEAR(flip_definition::tone(0.25 * std::exp2(exposures.stop)), 0.85, 1e-6);
    EXPECT_EQ(exposures.count, 4);  // log2(14) = 3.8, rounded up
}

TEST(Exposures, DoWithoutAMedian) {
    // The median is 0; of what is above 0 it is 1/2.
    const Picture picture = picture_by(9, 1, [](int x, int) { return glm::vec3(x < 6 ? 0.0f : 0.5f); });
    const Exposures exposures = exposures_of({&picture});
    EXPECT_NEAR(exposures.stop, exposures.start, 1e-6);
    EXPECT_EQ(exposures.count, 2);
    const Picture black = constant(4, 4, {0, 0, 0});
    EXPECT_EQ(exposures_of({&black}).start, 0);
    EXPECT_EQ(exposures_of({&black}).stop, 0);
    EXPECT_EQ(exposures_of({}).count, 2);
}

TEST(Exposures, AreNotMoreThanTheMost) {
    // Over 30 decades, 100 stops.
    const Picture picture = picture_by(8, 1, [](int x, int) { return glm::vec3(x == 0 ? 1e10f : 1e-20f); });
    const Exposures exposures = exposures_of({&picture});
    EXPECT_GT(exposures.stop - exposures.start, 99);
    EXPECT_EQ(exposures.count, kMostExposures);
}

TEST(Exposures, CoverAllReferences) {
    const Picture dark = constant(4, 4, {0.1f, 0.1f, 0.1f}), bright = constant(4, 3, {10, 10, 10});
    const Exposures exposures = exposures_of({&dark, &bright});
    EXPECT_NEAR(flip_definition::tone(10 * std::exp2(exposures.start)), 0.85, 1e-6);
    EXPECT_NEAR(flip_definition::tone(0.1 * std::exp2(exposures.stop)), 0.85, 1e-6);
    // Excluded pixels count neither for the largest nor for the median.
    Picture part = picture_by(3, 1, [](int x, int) { return glm::vec3(x == 0 ? 1.0f : 2.0f); });
    exclude(part, 1);
    exclude(part, 2);
    EXPECT_NEAR(flip_definition::tone(std::exp2(exposures_of({&part}).start)), 0.85, 1e-6);
}

}  // namespace
}  // namespace dapple::metrics
