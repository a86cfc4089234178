// The graded picture against programs that use OpenColorIO on their own: oiiotool (OpenImageIO) and
// ocioconvert (opencolorio-tools), with the config as a file. They take scene-linear float EXR and write
// graded half EXR.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "color/colour_chart.h"
#include "color/grader.h"
#include "image/exr.h"
#include "image/temporary_folder.h"
#include "source_dir.h"

namespace dapple::color {
namespace {

using test::run_program;
using test::TemporaryFolder;

const std::string kConfig = DAPPLE_SOURCE_DIR "/src/color/shipped_config.ocio";

std::string quoted(const std::string& text) {
    return "'" + text + "'";
}

/// A half's place in the order of all halves, from its value.
int place_of_half(float value) {
    if (value == 0) return 0;
    int exponent = 0;
    std::frexp(value, &exponent);
    const int step_exponent = std::max(exponent - 11, -24);
    const int place =
        static_cast<int>(std::ldexp(std::abs(value), -step_exponent)) + (step_exponent + 24) * 1024;
    return value < 0 ? -place : place;
}

/// Halves between both pictures, at most, over all pixels of R, G, B.
int farthest_halves(const image::Image& a, const image::Image& b) {
    int farthest = 0;
    for (const char* name : {"R", "G", "B"}) {
        const auto& x = a.find(name)->values;
        const auto& y = b.find(name)->values;
        if (x.size() != y.size()) return 1 << 20;
        for (std::size_t i = 0; i < x.size(); ++i) {
            farthest = std::max(farthest, std::abs(place_of_half(x[i]) - place_of_half(y[i])));
        }
    }
    return farthest;
}

struct Case {
    const char* display;
    const char* view;
    const char* look;
};

void PrintTo(const Case& item, std::ostream* out) {
    *out << item.display << " / " << item.view << " / " << item.look;
}

class Reference : public testing::TestWithParam<Case> {};

// The same library computes the same floats, so that both round to the same half. One half apart is allowed,
// for a program that hands OCIO its pixels in another layout, whose code may round a float otherwise.
constexpr int kHalfRounding = 1;

TEST_P(Reference, EqualsOpenImageIoToHalfRounding) {
    const TemporaryFolder folder;
    const auto& [display, view, look] = GetParam();
    const image::Image chart = test::colour_chart();
    const Grader grader({kConfig, display, view, look});
    image::write_exr_verified(folder / "linear.exr", chart);
    image::write_exr_verified(folder / "ours.exr", grader.apply(chart, {}).picture);
    // A step of its own: the `looks` option of --ociodisplay does nothing in OpenImageIO 2.4.7.
    const std::string look_step = *look != 0 ? " --ociolook:from=ACEScg:to=ACEScg " + quoted(look) : "";
    ASSERT_EQ(run_program("oiiotool --colorconfig " + quoted(kConfig) + " " + quoted(folder / "linear.exr") +
                          look_step + " --ociodisplay:from=ACEScg " + quoted(display) + " " + quoted(view) +
                          " -d half -o " + quoted(folder / "theirs.exr")),
              0);
    const image::Image theirs = image::read_exr(folder / "theirs.exr");
    const int farthest = farthest_halves(image::read_exr(folder / "ours.exr"), theirs);
    RecordProperty("farthest_halves", farthest);
    EXPECT_LE(farthest, kHalfRounding);
    // The test sees a grade that is not the same: a 50th of a stop is many halves.
    image::write_exr_verified(folder / "other.exr", grader.apply(chart, {0.02, {}}).picture);
    EXPECT_GT(farthest_halves(image::read_exr(folder / "other.exr"), theirs), 4);
}

INSTANTIATE_TEST_SUITE_P(Views, Reference,
                         testing::Values(Case{"sRGB", "ACES 1.0 - SDR Video", ""},
                                         Case{"Rec.1886 Rec.709", "ACES 1.0 - SDR Video", ""},
                                         Case{"sRGB", "Un-tone-mapped", ""},
                                         Case{"sRGB", "ACES 1.0 - SDR Video", "Lagoon"},
                                         Case{"sRGB", "Raw", ""}));

TEST(ReferenceProgram, EqualsOcioconvertToHalfRounding) {
    const TemporaryFolder folder;
    const image::Image chart = test::colour_chart();
    const Grader grader({kConfig, "sRGB", "ACES 1.0 - SDR Video", ""});
    image::write_exr_verified(folder / "linear.exr", chart);
    image::write_exr_verified(folder / "ours.exr", grader.apply(chart, {}).picture);
    ASSERT_EQ(run_program("OCIO=" + quoted(kConfig) + " ocioconvert --view " + quoted(folder / "linear.exr") +
                          " ACEScg " + quoted(folder / "theirs.exr") + " sRGB 'ACES 1.0 - SDR Video'"),
              0);
    // ocioconvert writes float: our encoder rounds it.
    image::Image theirs = image::read_exr(folder / "theirs.exr");
    for (image::Channel& channel : theirs.channels) channel.type = image::PixelType::half_float;
    theirs = image::decode_exr(image::encode_exr(theirs).bytes, "theirs");
    EXPECT_LE(farthest_halves(image::read_exr(folder / "ours.exr"), theirs), kHalfRounding);
}

}  // namespace
}  // namespace dapple::color
