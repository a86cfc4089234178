// Errors of a run against a reference, on pictures whose figures can be told by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "image/exr.h"
#include "image/temporary_folder.h"
#include "judge/bench_errors.h"
#include "judge/bench_hard_cases.h"
#include "judge/check.h"
#include "metrics/flip.h"

namespace dapple::judge {
namespace {

constexpr int kWidth = 8, kHeight = 4;

/// What a frame of the made-up clip shows.
struct Shown {
    float light = 1;       ///< E, and R, G, B
    float variance = 0;    ///< of E's channels
    int columns = kWidth;  ///< so many are covered, from the left
    float scattered = 0;   ///< S, in all columns; 0: there is no such layer
    float scattered_variance = 0;
};

image::Image picture_of(const Shown& shown) {
    image::Image image;
    image.width = kWidth;
    image.height = kHeight;
    const auto add = [&](const std::string& name, const std::function<float(int x, int y)>& value) {
        std::vector<float>& values = image.add(name).values;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) values[static_cast<std::size_t>(y * kWidth + x)] = value(x, y);
    };
    const auto in_columns = [&](float value) {
        return [=](int x, int) { return x < shown.columns ? value : 0.0f; };
    };
    add("covered", in_columns(1));
    for (const char* c : {"R", "G", "B"}) {
        add(c, in_columns(shown.light));
        add(std::string("E.") + c, in_columns(shown.light));
        add(std::string("E.variance.") + c, in_columns(shown.variance));
    }
    if (shown.scattered > 0) {
        for (const char* c : {"R", "G", "B"}) {
            add(std::string("volume_caustics.") + c, [&](int, int) { return shown.scattered; });
            add(std::string("S.variance.") + c, [&](int, int) { return shown.scattered_variance; });
        }
    }
    // A floor, seen from above.
    for (const char* c : {"X", "Y", "Z"}) {
        add(std::string("P.") + c, [&](int x, int y) {
            return static_cast<float>(*c == 'X' ? x : *c == 'Z' ? y : 0);
        });
        add(std::string("N.") + c, [&](int, int) { return *c == 'Y' ? 1.0f : 0.0f; });
    }
    return image;
}

class ErrorJudgeTest : public testing::Test {
protected:
    run::OutputPaths clip(const std::string& name, const std::vector<Shown>& frames) {
        run::OutputPaths paths(folder_ / name, "clip");
        paths.make_folders();
        for (std::size_t i = 0; i < frames.size(); ++i)
            image::write_exr_verified(paths.linear(static_cast<std::int64_t>(i) + 1), picture_of(frames[i]));
        return paths;
    }
    /// By a reference of one sample a pixel.
    ErrorJudge judge_by(const std::vector<Shown>& reference) {
        std::vector<std::int64_t> frames;
        for (std::size_t i = 0; i < reference.size(); ++i) frames.push_back(static_cast<std::int64_t>(i) + 1);
        return {clip("reference", reference), frames, "E", 1};
    }

    std::string reference_folder() const { return folder_ / "reference"; }

private:
    test::TemporaryFolder folder_;
};

TEST_F(ErrorJudgeTest, LightWhereTheReferenceHasNoneIsAnInfiniteError) {
    const ErrorJudge judge = judge_by({{.light = 0}});
    EXPECT_EQ(judge.noise().mean, 0);
    const ErrorJudge::Judged leak = judge.judge(clip("leak", {{.light = 1e-3f}}));
    for (const double figure : {leak.errors.energy, leak.errors.bias, leak.errors.l1, leak.errors.l1_inside,
                                leak.errors.rmse, leak.errors.rmse_less_noise, leak.errors.block_rmse})
        EXPECT_EQ(figure, std::numeric_limits<double>::infinity());
    EXPECT_EQ(leak.map.values.at(0), std::numeric_limits<float>::infinity());
    const ErrorJudge::Judged dark = judge.judge(clip("dark", {{.light = 0}}));
    for (const double figure : {dark.errors.energy, dark.errors.bias, dark.errors.l1, dark.errors.rmse})
        EXPECT_EQ(figure, 0);
    EXPECT_EQ(dark.map.values.at(0), 0);
}

TEST_F(ErrorJudgeTest, SharesAreOfTheReferenceAndFlickerOfTheRun) {
    const ErrorJudge judge = judge_by({{1}, {1}, {1}});
    // D is 1, 2, 1; the mean of I is 7/3.
    const ClipErrors errors = judge.judge(clip("run", {{2}, {3}, {2}})).errors;
    EXPECT_NEAR(errors.bias, 4.0 / 3, 1e-6);
    EXPECT_NEAR(errors.energy, 4.0 / 3, 1e-6);
    EXPECT_NEAR(errors.rmse, std::sqrt((1 + 4 + 1) / 3.0), 1e-6);
    ASSERT_TRUE(errors.flicker);
    EXPECT_NEAR(*errors.flicker, 1 / (49.0 / 9), 1e-6);
    EXPECT_FALSE(judge_by({{1}, {1}}).judge(clip("two", {{2}, {3}})).errors.flicker);
}

TEST_F(ErrorJudgeTest, CheckTellsTheSameErrors) {
    // A dark frame with a large share of error: a mean over the frames' shares would tell another figure.
    const ErrorJudge judge = judge_by({{4}, {0.125f}, {2}});
    const run::OutputPaths run = clip("run", {{5}, {0.5f}, {1.5f}});
    const ClipErrors errors = judge.judge(run).errors;
    EXPECT_NEAR(errors.rmse, std::sqrt((1 + 0.140625 + 0.25) / 3) / (6.125 / 3), 1e-6);
    CheckOptions options;
    options.sequence = run.linear_folder();
    options.reference = run::OutputPaths(reference_folder(), "clip").linear_folder();
    options.layer = "E";
    const CheckResult checked = check(options);
    EXPECT_NEAR(checked.clip.at("relative_rmse").mean, errors.rmse, 1e-9);
    EXPECT_NEAR(checked.clip.at("relative_mae").mean, errors.l1, 1e-9);
    EXPECT_NEAR(checked.clip.at("relative_bias").mean, errors.bias, 1e-9);
    EXPECT_NEAR(checked.flicker.flicker, errors.flicker.value(), 1e-9);
}

TEST_F(ErrorJudgeTest, TheReferencesNoiseIsTakenOff) {
    const ErrorJudge judge = judge_by({{.light = 1, .variance = 0.04f}});
    ASSERT_TRUE(judge.noise().rmse);
    EXPECT_NEAR(*judge.noise().rmse, 0.2, 1e-6);
    EXPECT_NEAR(judge.judge(clip("far", {{.light = 1.25f}})).errors.rmse_less_noise, 0.15, 1e-6);
    EXPECT_EQ(judge.judge(clip("near", {{.light = 1.1f}})).errors.rmse_less_noise, 0);
}

TEST_F(ErrorJudgeTest, ScatteredLightIsOfAllPixelsAndHasANoiseOfItsOwn) {
    // Two of eight columns see a receiver, and none of that light is right.
    const Shown truth{.light = 1, .columns = 2, .scattered = 1, .scattered_variance = 0.04f};
    const run::OutputPaths reference = clip("reference", {truth});
    const ErrorJudge judge(reference, {1}, kScatteredLayer, 1);
    EXPECT_EQ(judge.noise().pixels, kWidth * kHeight);
    EXPECT_NEAR(judge.noise().mean, 1, 1e-6);
    ASSERT_TRUE(judge.noise().rmse);
    EXPECT_NEAR(*judge.noise().rmse, 0.2, 1e-6);
    const run::OutputPaths run = clip("run", {{.light = 3, .columns = 4, .scattered = 1.25f}});
    const ClipErrors errors = judge.judge(run).errors;
    EXPECT_NEAR(errors.l1, 0.25, 1e-6);
    EXPECT_NEAR(errors.bias, 0.25, 1e-6);
    EXPECT_NEAR(errors.rmse_less_noise, 0.15, 1e-6);
    EXPECT_EQ(errors.compared, 1);
    EXPECT_TRUE(has_layer(run, 1, kScatteredLayer));
    EXPECT_FALSE(has_layer(clip("clear", {{}}), 1, kScatteredLayer));
}

TEST_F(ErrorJudgeTest, ASumOverFewCoveredPixelsMayBeOffByMore) {
    // Two of eight columns: 8 pixels with a deviation of 0.2.
    const ErrorJudge judge = judge_by({{.light = 1, .variance = 0.04f, .columns = 2}});
    EXPECT_EQ(judge.noise().pixels, 8);
    EXPECT_NEAR(energy_tolerance(judge.noise()), 0.01 + 3 * 0.2 / std::sqrt(8.0), 1e-6);
    EXPECT_NEAR(energy_tolerance(judge.noise(), 0.25), 0.01 + 3 * 0.2 / std::sqrt(2.0), 1e-6);
    // Without noise, or without light.
    EXPECT_EQ(energy_tolerance(ReferenceNoise{}), 0.01);
}

TEST_F(ErrorJudgeTest, ExposuresAreOfTheFirstMiddleAndLastFrame) {
    // The second frame, which is none of these, would ask for others.
    const ErrorJudge judge = judge_by({{1}, {1000}, {2}, {1e-3f}, {4}});
    std::vector<metrics::Picture> pictures;
    for (const float light : {1.0f, 2.0f, 4.0f}) {
        const image::Image image = picture_of({light});
        pictures.push_back(metrics::picture_of(image, "", ""));
        metrics::to_rec709(pictures.back(), image);
    }
    const metrics::Exposures expected = metrics::exposures_of({&pictures[0], &pictures[1], &pictures[2]});
    EXPECT_DOUBLE_EQ(judge.exposures().start, expected.start);
    EXPECT_DOUBLE_EQ(judge.exposures().stop, expected.stop);
}

}  // namespace
}  // namespace dapple::judge
