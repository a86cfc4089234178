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
    float light = 1;             ///< E, and R, G, B
    float variance = 0;          ///< of E's channels; below 0: there is no such layer
    int columns = kWidth;        ///< so many are covered, from the left
    float scattered = 0;         ///< S, in all columns; 0: there is no such layer
    float scattered_right = -1;  ///< S in the right half, where it is another
    float scattered_variance = 0;
    float light_right = -1;  ///< E in the right half, where it is another
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
        add(std::string("E.") + c, [&](int x, int) {
            if (x >= shown.columns) return 0.0f;
            return shown.light_right >= 0 && x >= kWidth / 2 ? shown.light_right : shown.light;
        });
        if (shown.variance >= 0) add(std::string("E.variance.") + c, in_columns(shown.variance));
    }
    if (shown.scattered > 0) {
        for (const char* c : {"R", "G", "B"}) {
            add(std::string("volume_caustics.") + c, [&](int x, int) {
                return shown.scattered_right >= 0 && x >= kWidth / 2 ? shown.scattered_right
                                                                     : shown.scattered;
            });
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

TEST_F(ErrorJudgeTest, TellsContrastDarkPixelsAndTheLargestDifference) {
    const ErrorJudge judge = judge_by({{.light = 1, .light_right = 3}});
    const ClipErrors even = judge.judge(clip("even", {{.light = 2}})).errors;
    EXPECT_EQ(even.detail, 0);
    EXPECT_EQ(even.dark, 0);
    EXPECT_NEAR(even.largest, 0.5, 1e-6);
    const ClipErrors half = judge.judge(clip("half", {{.light = 0, .light_right = 1}})).errors;
    EXPECT_NEAR(half.detail, 0.5, 1e-6);
    EXPECT_EQ(half.dark, 0.5);
    EXPECT_NEAR(half.largest, 1, 1e-6);
    EXPECT_EQ(judge_by({{}}).judge(clip("level", {{}})).errors.detail, 1) << "there is none in either";
}

TEST_F(ErrorJudgeTest, AReferenceWithoutAVarianceHasNoNoiseThatIsKnown) {
    const ErrorJudge judge = judge_by({{.light = 1, .variance = -1}});
    EXPECT_FALSE(judge.noise().rmse);
    EXPECT_NEAR(judge.judge(clip("far", {{.light = 1.25f}})).errors.rmse_less_noise, 0.25, 1e-6);
}

/// A reference whose S is 1, with hardly any noise, and a verdict on runs by it.
class ScatteredVerdictTest : public ErrorJudgeTest {
protected:
    static constexpr Shown kTruth{.light = 1, .scattered = 1, .scattered_variance = 1e-8f};
    ScatteredVerdict verdict(const Shown& shown, ScatteredEvidence evidence = {}) {
        const ErrorJudge judge(clip("reference", {kTruth}), {1}, kScatteredLayer, 1);
        evidence.answered = [](std::int64_t) {
            std::vector<bool> left(static_cast<std::size_t>(kWidth * kHeight));
            for (std::size_t i = 0; i < left.size(); ++i) left[i] = i % kWidth < kWidth / 2;
            return left;
        };
        return judge_scattered(judge, clip("run", {shown}), evidence);
    }
};

TEST_F(ScatteredVerdictTest, DarkScatteredLightFailsThoughEIsRight) {
    const Shown dark{.light = 1, .scattered = 0.97f};
    const ErrorJudge of_surfaces(clip("reference", {kTruth}), {1}, "E", 1);
    EXPECT_LE(std::abs(of_surfaces.judge(clip("run", {dark})).errors.energy),
              energy_tolerance(of_surfaces.noise()));
    const ScatteredVerdict failed = verdict(dark);
    EXPECT_EQ(failed.verdict, Verdict::fails);
    EXPECT_NEAR(failed.energy, -0.03, 1e-6);
    EXPECT_THAT(failed.reason, testing::HasSubstr("S -3.00 % of ±1.00 %"));
    EXPECT_EQ(verdict({.light = 1, .scattered = 1.03f}).verdict, Verdict::fails);
    EXPECT_EQ(verdict({.light = 1, .scattered = 0.995f}).verdict, Verdict::holds);
    // What the reference's own standard error allows: 1 % and three times 0.7 %.
    EXPECT_EQ(verdict(dark, {.reference_error = 0.007}).verdict, Verdict::holds);
    EXPECT_EQ(verdict(dark, {.reference_error = 0.006}).verdict, Verdict::fails);
}

TEST_F(ScatteredVerdictTest, LossesOfTheMethodsOwnAccountForMissingLight) {
    const Shown dark{.light = 1, .scattered = 0.9f};
    const auto with = [](const char* loss, double watts) {
        return ScatteredEvidence{.counts = {{"light on specular surfaces, W", 50}, {loss, watts}}};
    };
    EXPECT_EQ(verdict(dark, with("lost in weak beams, W", 4.6)).verdict, Verdict::named);
    EXPECT_THAT(verdict(dark, with("lost in weak beams, W", 4.6)).reason, testing::HasSubstr("9.20 %"));
    // 10 % are missing, of which 1 % may be.
    EXPECT_EQ(verdict(dark, with("lost in weak beams, W", 4.4)).verdict, Verdict::fails);
    // The reference does not have what no method could keep, either.
    EXPECT_EQ(verdict(dark, with("lost beyond the scene, W", 25)).verdict, Verdict::fails);
    EXPECT_EQ(verdict(dark, with("lost to wave shadow, W", 25)).verdict, Verdict::fails);
    // Losses are no excuse for light that is too much.
    EXPECT_EQ(verdict({.light = 1, .scattered = 1.1f}, with("lost in weak beams, W", 10)).verdict,
              Verdict::fails);
    EXPECT_EQ(lost_by_method({{"lost at silhouettes, W", 1}, {"lost outside cones, W", 2}, {"beams", 3}}), 1);
}

TEST_F(ScatteredVerdictTest, WhatThePlanLeavesOutIsNamedWhereTheRestHolds) {
    const ScatteredEvidence plan{.plan = "not behind water"};
    const ScatteredVerdict named = verdict({.light = 1, .scattered = 1, .scattered_right = 0.2f}, plan);
    EXPECT_EQ(named.verdict, Verdict::named);
    EXPECT_THAT(named.reason, testing::HasSubstr("not behind water"));
    EXPECT_EQ(verdict({.light = 1, .scattered = 0.97f, .scattered_right = 0.2f}, plan).verdict,
              Verdict::fails);
    EXPECT_EQ(verdict({.light = 1, .scattered = 1, .scattered_right = 0.2f}).verdict, Verdict::fails)
        << "no plan says so";
    EXPECT_EQ(verdict({.light = 1, .scattered = 1, .scattered_right = 1.2f}, plan).verdict, Verdict::fails)
        << "a plan explains no light that is too much";
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

TEST_F(ErrorJudgeTest, DarkPartsAreHeldAgainstTheWholePicturesLight) {
    const ErrorJudge judge = judge_by({{.light = 0.1f, .light_right = 0.3f}});
    const ClipErrors errors = judge.judge(clip("dark", {{.light = 0}})).errors;
    EXPECT_NEAR(errors.mean, 0.2, 1e-6);
    EXPECT_NEAR(energy_where_compared(errors, judge.noise()), -1, 1e-6);
    ReferenceNoise of_all = judge.noise();
    of_all.mean = 20;
    EXPECT_NEAR(energy_where_compared(errors, of_all), -0.01, 1e-6);
    of_all.mean = 0.02;
    EXPECT_NEAR(energy_where_compared(errors, of_all), -1, 1e-6);
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
