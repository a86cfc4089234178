#include "color/grader.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "base/hash.h"
#include "base/parallel.h"
#include "color/colour_chart.h"
#include "source_dir.h"

namespace dapple::color {
namespace {

using test::row_of;

const std::string kConfig = DAPPLE_SOURCE_DIR "/src/color/shipped_config.ocio";

Grader grader_of(const std::string& view) {
    return Grader({kConfig, "sRGB", view, ""});
}

/// IEC 61966-2-1.
double srgb_encoded(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}
double srgb_decoded(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

/// Academy S-2016-001.
double acescct_encoded(double linear) {
    return linear <= 0.0078125 ? 10.5402377416545 * linear + 0.0729055341958355
                               : (std::log2(linear) + 9.72) / 17.52;
}
double acescct_decoded(double code) {
    return code <= 0.155251141552511 ? (code - 0.0729055341958355) / 10.5402377416545
                                     : std::exp2(code * 17.52 - 9.72);
}

/// ASC CDL v1.2 without its clamps.
glm::dvec3 cdl_applied(const Cdl& cdl, glm::dvec3 in) {
    glm::dvec3 out;
    for (int c = 0; c < 3; ++c) {
        const double value = in[c] * cdl.slope[c] + cdl.offset[c];
        out[c] = value > 0 ? std::pow(value, cdl.power[c]) : value;
    }
    const double luma = glm::dot(out, glm::dvec3(0.2126, 0.7152, 0.0722));
    return luma + cdl.saturation * (out - luma);
}

// OCIO computes powers and logarithms by polynomials in float; what it adds must stay below what a half of
// the graded file rounds away anyway, 2^-11 of the value.
constexpr double kHalf = 0x1p-11;

TEST(Grader, GreyGoesThroughTheDisplaysCurve) {
    const Grader grader = grader_of("Un-tone-mapped");
    const std::vector<float> greys{0.001f, 0.0031308f, 0.02f, 0.18f, 0.5f, 1.0f};
    std::vector<glm::vec3> colours;
    for (const float grey : greys) colours.emplace_back(grey);
    const image::Image graded = grader.apply(row_of(colours), {}).picture;
    for (std::size_t i = 0; i < greys.size(); ++i) {
        for (const image::Channel& channel : graded.channels) {
            EXPECT_NEAR(channel.values[i], srgb_encoded(greys[i]), kHalf * srgb_encoded(greys[i]))
                << greys[i];
        }
    }
}

// The published value of 18 % grey through ACES 1.0 SDR video is 10 cd/m^2 of 100, in sRGB code 0.349.
TEST(Grader, AcesPutsMiddleGreyAtATenth) {
    const image::Image graded =
        grader_of("ACES 1.0 - SDR Video").apply(row_of({glm::vec3(0.18f)}), {}).picture;
    EXPECT_NEAR(graded.find("G")->values[0], srgb_encoded(0.1), 0.01);
}

TEST(Grader, ExposureIsAFactor) {
    const Grader grader = grader_of("Raw");
    const image::Image chart = test::colour_chart();
    for (const double stops : {-3.0, 0.5, 2.0}) {
        const image::Image graded = grader.apply(chart, {stops, {}}).picture;
        for (const image::Channel& channel : chart.channels) {
            const auto& values = graded.find(channel.name)->values;
            for (std::size_t i = 0; i < values.size(); ++i) {
                const double expected = channel.values[i] * std::exp2(stops);
                // The factor and the product are rounded to float once each.
                ASSERT_NEAR(values[i], expected, 0x1p-22 * std::abs(expected)) << stops;
            }
        }
    }
}

TEST(Grader, ExposureComesFirst) {
    const Grader grader = grader_of("ACES 1.0 - SDR Video");
    image::Image chart = test::colour_chart();
    Grade grade{1, {}};
    grade.cdl.slope = {1.1, 1, 0.9};
    const image::Image graded = grader.apply(chart, grade).picture;
    for (image::Channel& channel : chart.channels) {
        for (float& value : channel.values) value *= 2;
    }
    grade.exposure = 0;
    const image::Image doubled = grader.apply(chart, grade).picture;
    for (const image::Channel& channel : graded.channels) {
        const auto& values = doubled.find(channel.name)->values;
        for (std::size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(values[i], channel.values[i], 1e-6);
    }
}

TEST(Grader, CdlIsAppliedInAcescct) {
    const Grader grader = grader_of("Raw");  // shows scene-linear values as they are
    Grade grade;
    grade.exposure = -0.5;
    grade.cdl = {{1.1, 0.95, 1.05}, {-0.02, 0.01, 0.03}, {1.1, 0.9, 1.2}, 0.7};
    const image::Image chart = test::colour_chart();
    const image::Image graded = grader.apply(chart, grade).picture;
    for (std::size_t i = 0; i < chart.pixels(); ++i) {
        glm::dvec3 code;
        for (std::size_t c = 0; c < 3; ++c) {
            code[static_cast<int>(c)] = acescct_encoded(chart.channels[c].values[i] * std::exp2(-0.5));
        }
        code = cdl_applied(grade.cdl, code);
        for (std::size_t c = 0; c < 3; ++c) {
            const double expected = acescct_decoded(code[static_cast<int>(c)]);
            // The toe's end is held to its own size: there ACEScct is linear about -0.007.
            const double allowed = kHalf * std::max(std::abs(expected), 0.007);
            ASSERT_NEAR(graded.channels[c].values[i], expected, allowed) << "pixel " << i << " channel " << c;
        }
    }
}

TEST(Grader, LookIsItsCdl) {
    Grade grade;  // the numbers of the shipped config's look
    grade.cdl = {{1.06, 1.04, 1.02}, {-0.028, -0.016, -0.004}, {1, 1, 1}, 1.12};
    const image::Image chart = test::colour_chart();
    const image::Image by_cdl = grader_of("ACES 1.0 - SDR Video").apply(chart, grade).picture;
    const image::Image by_look =
        Grader({kConfig, "sRGB", "ACES 1.0 - SDR Video", "Lagoon"}).apply(chart, {}).picture;
    for (const image::Channel& channel : by_cdl.channels) {
        const auto& values = by_look.find(channel.name)->values;
        for (std::size_t i = 0; i < values.size(); ++i) {
            ASSERT_NEAR(values[i], channel.values[i], kHalf * std::max(1.0f, std::abs(values[i])));
        }
    }
}

TEST(Grader, BitsDoNotDependOnThreads) {
    const Grader grader = grader_of("ACES 1.0 - SDR Video");
    const image::Image chart = test::colour_chart(301, 97);
    Grade grade{0.3, {}};
    grade.cdl.saturation = 1.2;
    set_thread_count(1);
    const image::Image alone = grader.apply(chart, grade).picture;
    set_thread_count(2);
    const image::Image together = grader.apply(chart, grade).picture;
    for (const image::Channel& channel : alone.channels) {
        EXPECT_EQ(together.find(channel.name)->values, channel.values);
    }
}

TEST(Grader, NanAndInfinityAreCountedAndGone) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    const GradedPicture graded = grader_of("ACES 1.0 - SDR Video")
                                     .apply(row_of({{nan, infinity, -infinity}, {0, 0, 0}, {1, nan, 1}}), {});
    EXPECT_EQ(graded.non_finite, 4u);
    for (const image::Channel& channel : graded.picture.channels) {
        EXPECT_EQ(channel.values[0], channel.values[1]);  // as black
        EXPECT_TRUE(std::isfinite(channel.values[2]));
    }
    // What grading itself makes infinite is found as well.
    EXPECT_EQ(grader_of("Raw").apply(row_of({{1e30f, 1, 0}}), {60, {}}).non_finite, 1u);
}

TEST(Grader, IdsTellGradesApart) {
    const Grader grader = grader_of("ACES 1.0 - SDR Video");
    Grade warm;
    warm.cdl.slope = {1.1, 1, 1};
    const std::string plain_id = grader.processor_id({});
    EXPECT_NE(grader.processor_id(warm), plain_id);
    EXPECT_NE(grader.processor_id({1, {}}), plain_id);
    EXPECT_EQ(grader.processor_id({}), plain_id);
    EXPECT_NE(grader_of("Raw").processor_id({}), plain_id);
}

TEST(Grader, AcescgPrimariesAreRecognised) {
    EXPECT_EQ(grader_of("Raw").working_chromaticities(), image::kAcesCgChromaticities);
}

TEST(Grader, MetadataNamesTheView) {
    EXPECT_THAT(grader_of("Raw").metadata(),
                testing::IsSupersetOf({testing::Pair("dapple:ocio_config", "dapple-aces-1.0-sdr"),
                                       testing::Pair("dapple:ocio_view", "Raw"),
                                       testing::Pair("dapple:ocio_display", "sRGB")}));
}

TEST(TextureColour, GreyStaysGreyAndIsDecoded) {
    const Grader grader = grader_of("Raw");
    std::vector<float> rgb;
    for (int code = 0; code < 256; ++code) rgb.insert(rgb.end(), 3, static_cast<float>(code) / 255.0f);
    rgb.insert(rgb.end(), 3, 0.5f);
    std::vector<float> linear = rgb;
    grader.texture_to_linear(linear);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        // Half a step of 8 bits is 100 times as much.
        EXPECT_NEAR(linear[i], srgb_decoded(rgb[i]), 2e-5) << rgb[i];
    }
    EXPECT_NEAR(linear[linear.size() - 1], 0.21404, 2e-5);
}

// AP1 from Rec.709 with Bradford's adaptation from D65 to the ACES white: the first column of the published
// matrix.
TEST(TextureColour, PrimariesMoveToAp1) {
    std::vector<float> rgb{1, 0, 0};
    grader_of("Raw").texture_to_linear(rgb);
    EXPECT_NEAR(rgb[0], 0.613097, 1e-4);
    EXPECT_NEAR(rgb[1], 0.070194, 1e-4);
    EXPECT_NEAR(rgb[2], 0.020616, 1e-4);
}

TEST(TextureColour, BitsDoNotDependOnThreads) {
    const Grader grader = grader_of("Raw");
    std::vector<float> alone(3 * 20'000);
    for (std::size_t i = 0; i < alone.size(); ++i) alone[i] = static_cast<float>(hash_uniform(1, 0, i, 0));
    std::vector<float> together = alone;
    set_thread_count(1);
    grader.texture_to_linear(alone);
    set_thread_count(2);
    grader.texture_to_linear(together);
    EXPECT_EQ(alone, together);
}

}  // namespace
}  // namespace dapple::color
