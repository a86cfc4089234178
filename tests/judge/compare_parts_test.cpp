// What is found of the sequences before anything is drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "image/code_values.h"
#include "image/png.h"
#include "judge/compare_scene.h"

namespace dapple::judge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_tools::ScratchFolder;

glm::vec3 grey(float value) {
    return {value, value, value};
}

color::ViewSettings view_of(const std::string& name) {
    color::ViewSettings settings;
    settings.view = name;
    return settings;
}

/// The exit code and message of what plan_comparison throws.
std::pair<ExitCode, std::string> refusal(const CompareOptions& options) {
    try {
        plan_comparison(options);
    } catch (const Error& error) {
        return {error.code(), error.what()};
    }
    return {ExitCode::done, ""};
}

TEST(ComparePlan, LabelsAreWhatTellsNamesApart) {
    EXPECT_THAT(short_labels({"/a/b/sliced", "/a/b/splat/"}), ElementsAre("sliced", "splat"));
    EXPECT_THAT(short_labels({"a/one/manifest.json", "a/two/manifest.json"}), ElementsAre("one", "two"));
    EXPECT_THAT(short_labels({"x/linear/clip.%04d.exr", "y/linear/clip.%04d.exr"}),
                ElementsAre("x/linear/clip.%04d.exr", "y/linear/clip.%04d.exr"));
    EXPECT_THAT(short_labels({"same", "same"}), ElementsAre("same", "same"));
}

TEST(ComparePlan, RatesAreExact) {
    for (const auto& [fps, numerator, denominator] : {std::tuple{24.0, 24, 1},
                                                      {23.976, 24000, 1001},
                                                      {23.98, 24000, 1001},
                                                      {29.97, 30000, 1001},
                                                      {59.94, 60000, 1001},
                                                      {24000.0 / 1001, 24000, 1001},
                                                      {12.5, 12500, 1000},
                                                      {25.0, 25, 1}}) {
        const scene::Rational rate = exact_rate(fps);
        EXPECT_EQ(rate.numerator, numerator) << fps;
        EXPECT_EQ(rate.denominator, denominator) << fps;
    }
}

TEST(ComparePlan, FramesAreThoseOfAllClips) {
    const ScratchFolder folder;
    const std::string a = write_clip(folder, "a", 8, 4, {1, 2, 3, 4, 6, 7}, busy);
    const std::string b = write_clip(folder, "b", 8, 4, {3, 4, 8, 9}, busy);
    CompareOptions options{.sequences = {a, b}};
    EXPECT_THAT(plan_comparison(options).frames, ElementsAre(3, 4, 5, 6, 7));
    EXPECT_THAT(plan_comparison(options).labels, ElementsAre("a.%04d.exr", "b.%04d.exr"));
    options.frames = FrameSet::parse("9,1-4x3");
    EXPECT_THAT(plan_comparison(options).frames, ElementsAre(1, 4, 9));
}

TEST(ComparePlan, WhatDoesNotFitIsRefusedByName) {
    const ScratchFolder folder;
    const std::string a = write_clip(folder, "a", 8, 4, {1, 2}, busy);
    const std::string later = write_clip(folder, "later", 8, 4, {5, 6}, busy);
    const std::string larger = write_clip(folder, "larger", 9, 4, {1, 2}, busy);

    const auto sizes = refusal({.sequences = {a, larger}});
    EXPECT_EQ(sizes.first, ExitCode::input_unreadable);
    EXPECT_THAT(sizes.second, HasSubstr(a + " is 8 x 4"));
    EXPECT_THAT(sizes.second, HasSubstr(larger + " is 9 x 4"));
    const auto apart = refusal({.sequences = {a, later}});
    EXPECT_EQ(apart.first, ExitCode::input_unreadable);
    EXPECT_THAT(apart.second, HasSubstr("no frame in common"));
    EXPECT_THAT(apart.second, HasSubstr(later + " has 5 to 6"));

    std::ofstream(folder / "bad.0001.exr") << "no picture";
    const auto unreadable = refusal({.sequences = {a, folder / "bad.%04d.exr"}});
    EXPECT_EQ(unreadable.first, ExitCode::input_unreadable);
    EXPECT_THAT(unreadable.second, HasSubstr("has no readable frame"));

    EXPECT_EQ(refusal({.sequences = {a}}).first, ExitCode::usage);
    EXPECT_EQ(refusal({.sequences = {a, a, a, a, a}}).first, ExitCode::usage);
    EXPECT_EQ(refusal({.sequences = {a, a}, .labels = {"one"}}).first, ExitCode::usage);
    EXPECT_EQ(refusal({.sequences = {a, a}, .slice_row = 4}).first, ExitCode::usage);
    EXPECT_EQ(refusal({.sequences = {a, a}, .slice_row = 3}).first, ExitCode::done);
}

class CompareLookTest : public testing::Test {
protected:
    ReadFrame read(const std::string& path) const {
        SequenceReader reader({find_sequence(path)}, {});
        return std::move(reader.next()[0]);
    }
    ScratchFolder folder;
};

TEST_F(CompareLookTest, GradesAsTheGraderDoes) {
    write_picture(folder / "p.1.exr", 97, 53, 1, busy);
    const Look look({}, 0.5, false);
    const color::Grader grader({});
    color::Grade grade;
    grade.exposure = 0.5;
    const std::vector<std::uint8_t> wanted =
        image::to_rgb8(grader.apply(image::read_exr(folder / "p.1.exr"), grade).picture);
    EXPECT_EQ(look.show(read(folder / "p.1.exr")).rgb, wanted);
    EXPECT_THAT(look.description(), HasSubstr("sRGB, ACES 1.0 - SDR Video, exposure 0.5"));
}

TEST_F(CompareLookTest, RowsAreThoseOfTheWholePicture) {
    write_picture(folder / "p.1.exr", 97, 53, 1, busy);
    const ReadFrame frame = read(folder / "p.1.exr");
    const Look look({}, 0, false);
    const std::vector<std::uint8_t> all = look.rows(frame, 0, 53);
    for (int y = 0; y < 53; ++y) {
        const auto begin = all.begin() + static_cast<std::ptrdiff_t>(3 * 97 * y);
        EXPECT_EQ(look.rows(frame, y, 1), std::vector<std::uint8_t>(begin, begin + 3 * 97)) << y;
    }
}

TEST_F(CompareLookTest, PngsAreShownAsTheyAre) {
    std::vector<std::uint8_t> codes(3 * 256);
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint8_t>(i % 256);
    image::write_png(folder / "p.0001.png", 256, 1, codes);
    const Look look({}, 2, true);
    EXPECT_EQ(look.show(read(folder / "p.0001.png")).rgb, codes);
}

TEST_F(CompareLookTest, PrimariesOfOtherRenderersAreTurned) {
    image::Image picture;
    picture.width = 2;
    picture.height = 1;
    picture.add("R").values = {1, 1};
    picture.add("G").values = {0, 1};
    picture.add("B").values = {0, 1};
    image::write_exr_verified(folder / "named.1.exr", picture,
                              {.chromaticities = image::kAcesCgChromaticities});
    image::write_exr_verified(folder / "unnamed.1.exr", picture);  // by OpenEXR's rule Rec.709
    const Look look(view_of("Un-tone-mapped"), 0, false);
    const std::vector<std::uint8_t> named = look.show(read(folder / "named.1.exr")).rgb;
    const std::vector<std::uint8_t> unnamed = look.show(read(folder / "unnamed.1.exr")).rgb;
    // The red of Rec.709 is code (255, 0, 0) on an sRGB display; white is white either way. One code is left
    // for the rounding of two white adaptations.
    EXPECT_NEAR(unnamed[0], 255, 1);
    EXPECT_NEAR(unnamed[1], 0, 1);
    EXPECT_NEAR(unnamed[2], 0, 1);
    for (std::size_t c = 3; c < 6; ++c) {
        EXPECT_NEAR(named[c], 255, 1);
        EXPECT_NEAR(unnamed[c], 255, 1);
    }
    // AP1's red is outside of the display's gamut: green is cut at 0 in both, but not the way there.
    const std::vector<std::uint8_t> dim_named =
        Look(view_of("Un-tone-mapped"), -2, false).show(read(folder / "named.1.exr")).rgb;
    const std::vector<std::uint8_t> dim_unnamed =
        Look(view_of("Un-tone-mapped"), -2, false).show(read(folder / "unnamed.1.exr")).rgb;
    EXPECT_GT(dim_named[0], dim_unnamed[0] + 10);
}

TEST_F(CompareLookTest, AnUnknownViewIsAWrongCall) {
    try {
        const Look look(view_of("no such view"), 0, false);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage);
        EXPECT_THAT(error.what(), HasSubstr("no such view"));
    }
}

TEST(CompareSurvey, MeasuresKnownClips) {
    const ScratchFolder folder;
    // Greys: luminance is the value, in any primaries. A stands still but for a flash of frame 3, B is a
    // quarter brighter than A's still frames.
    const std::string a = write_clip(folder, "a", 16, 8, {1, 2, 3, 4, 5},
                                     [](int, int, int frame) { return grey(frame == 3 ? 1.5f : 1.0f); });
    const std::string b =
        write_clip(folder, "b", 16, 8, {1, 2, 4, 5}, [](int, int, int) { return grey(1.25f); });
    const CompareOptions options{.sequences = {a, b}};
    const Prepared prepared(options);
    const SurveyedSequence &first = prepared.found.sequences[0], &second = prepared.found.sequences[1];
    const double mean = (4 * 1.0 + 1.5) / 5;
    // Rounding of luminance weights in float, and of grey by Bradford's matrix.
    EXPECT_NEAR(first.clip.mean, mean, 1e-6);
    EXPECT_NEAR(second.clip.mean, 1.25, 1e-6);
    ASSERT_EQ(first.clip.frames.size(), 3u);
    EXPECT_NEAR(first.clip.frames.at(2).flicker, 0.25 * 0.25 / (mean * mean), 1e-6);
    EXPECT_NEAR(first.clip.frames.at(3).flicker, 0.5 * 0.5 / (mean * mean), 1e-6);
    EXPECT_TRUE(second.clip.frames.empty()) << "no frame of B has both neighbours";
    EXPECT_THAT(second.missing, ElementsAre(3));
    EXPECT_TRUE(prepared.found.relative);
    EXPECT_EQ(prepared.found.unit, first.clip.mean);
    // |A - B| is 0.25 wherever both are: its bin ends at 0.3125, of the mean that is 0.284.
    EXPECT_DOUBLE_EQ(prepared.found.difference_full, 0.5);
    EXPECT_DOUBLE_EQ(Prepared({.sequences = {a, b}, .difference_scale = 0.3}).found.difference_full, 0.3);
    EXPECT_DOUBLE_EQ(Prepared({.sequences = {a, a}}).found.difference_full, 1) << "nothing differs";
}

TEST(CompareSurvey, DifferencesAreOfLuminanceAndKnowWhatIsNotFinite) {
    metrics::Picture a, b;
    a.width = b.width = 3;
    a.height = b.height = 1;
    a.luminance = {1, 0, 3};
    b.luminance = {0.5, 2, 0};
    a.excluded = {1};
    const std::vector<float> found = difference(a, b, 2);
    EXPECT_EQ(found[0], 0.25f);
    EXPECT_TRUE(std::isnan(found[1]));
    EXPECT_EQ(found[2], 1.5f);
}

TEST(CompareSurvey, ScalesAreRound) {
    for (const auto& [value, wanted] :
         {std::pair{0.3, 0.5}, {0.5, 0.5}, {0.51, 1.0}, {1.0, 1.0}, {17.0, 20.0}, {2.1e-7, 5e-7}}) {
        EXPECT_DOUBLE_EQ(round_up(value), wanted) << value;
    }
}

TEST(CompareSurvey, CodeValuesAndLightAreBothMeasuredAsGraded) {
    const ScratchFolder folder;
    const std::string linear = write_clip(folder, "a", 8, 4, {1}, [](int, int, int) { return grey(0.18f); });
    ReadOptions read;
    SequenceReader reader({find_sequence(linear)}, read);
    const Look look({}, 0, false);
    image::write_png(folder / "b.0001.png", 8, 4, look.show(reader.next()[0]).rgb);
    const Prepared prepared({.sequences = {linear, folder / "b.%04d.png"}});
    EXPECT_TRUE(prepared.comparison.displayed);
    EXPECT_FALSE(prepared.found.relative);
    // The PNG is the graded picture, rounded to 8 bits.
    EXPECT_NEAR(prepared.found.sequences[0].clip.mean, prepared.found.sequences[1].clip.mean, 0.5 / 255);
    EXPECT_GT(prepared.found.sequences[0].clip.mean, 0.25) << "not the 0.18 of the light";
}

}  // namespace
}  // namespace dapple::judge
