#include <gmock/gmock.h>

#include <cmath>

#include "base/hash.h"
#include "judge/defects_drift.h"
#include "judge/defects_jumps.h"
#include "judge/defects_shift.h"
#include "judge/synthetic_clip.h"
#include "metrics/picture.h"

namespace dapple::judge {
namespace {

using test::clean_frame;
using testing::IsEmpty;

constexpr int kFrames = 16;

metrics::Picture picture_of(const image::Image& frame) {
    return metrics::picture_of(frame, "", "test");
}

/// The jumps of a clip whose frames are edited.
std::vector<Jump> jumps_of(const test::Edit& edit) {
    JumpFinder finder(test::kWidth, test::kHeight, 0.4);
    for (int number = 1; number <= kFrames; ++number) {
        image::Image frame = clean_frame(number);
        edit(number, frame);
        finder.add(number, picture_of(frame), nullptr);
    }
    return finder.finish();
}

TEST(JumpFinder, MovingCausticsDoNotJump) {
    EXPECT_THAT(jumps_of([](int, image::Image&) {}), IsEmpty());
}

TEST(JumpFinder, NoiseOfEveryFrameDoesNotJump) {
    const auto jumps = jumps_of([](int number, image::Image& frame) {
        for (std::size_t i = 0; i < frame.pixels(); ++i) {
            const double noise = hash_uniform(3, static_cast<std::uint64_t>(number), i, 0) +
                                 hash_uniform(3, static_cast<std::uint64_t>(number), i, 1) - 1;
            for (image::Channel& channel : frame.channels) {
                channel.values[i] *= static_cast<float>(1 + 0.5 * noise);
            }
        }
    });
    EXPECT_THAT(jumps, IsEmpty());
}

TEST(JumpFinder, GlintsOfSinglePixelsDoNotJump) {
    const auto jumps = jumps_of([](int number, image::Image& frame) {
        for (std::uint64_t k = 0; k < 40; ++k) {
            const auto seed = static_cast<std::uint64_t>(number);
            frame.channels[1].values[hash_bits(5, seed, k, 0) % frame.pixels()] = 1e5f;
        }
    });
    EXPECT_THAT(jumps, IsEmpty());
}

/// As in deep water at 24 frames a second, where light focuses here in one frame and there in the next.
TEST(JumpFinder, FociThatPassInOneFrameDoNotJumpAndDoNotHideWhatDoes) {
    const auto foci = [](int number, image::Image& frame) {
        for (int k = 0; k < 3; ++k) {
            const auto place = [&](std::uint32_t axis, int blocks) {
                const auto seed = static_cast<std::uint64_t>(number);
                return 8 * static_cast<int>(hash_bits(7, seed, static_cast<std::uint64_t>(k), axis) %
                                            static_cast<std::uint32_t>(blocks));
            };
            test::scale(frame, 1.6, 40 * k + place(0, 4), place(1, 8), 16, 16);
        }
    };
    EXPECT_THAT(jumps_of(foci), IsEmpty());
    const auto jumps = jumps_of([&](int number, image::Image& frame) {
        foci(number, frame);
        if (number == 9) test::scale(frame, 5, 48, 24, 24, 24);
    });
    ASSERT_EQ(jumps.size(), 1U);
    EXPECT_EQ(jumps[0].frame, 9);
    EXPECT_EQ(jumps[0].kind, Jump::Kind::pop);
}

TEST(JumpFinder, AFlashIsFoundAtItsFrame) {
    for (const double factor : {1.05, 0.9, 1.5, 20.0}) {
        for (const int at : {2, 7, kFrames - 1}) {
            const auto jumps = jumps_of([&](int number, image::Image& frame) {
                if (number == at) test::scale(frame, factor);
            });
            ASSERT_EQ(jumps.size(), 1U) << factor << " at " << at;
            EXPECT_EQ(jumps[0].frame, at);
            EXPECT_EQ(jumps[0].kind, Jump::Kind::flash);
        }
    }
}

TEST(JumpFinder, APopIsFoundAtItsFrameAndPlace) {
    for (const double factor : {0.0, 0.5, 2.0}) {
        const auto jumps = jumps_of([&](int number, image::Image& frame) {
            if (number == 9) test::scale(frame, factor, 50, 30, 20, 20);
        });
        ASSERT_EQ(jumps.size(), 1U) << factor;
        EXPECT_EQ(jumps[0].frame, 9);
        EXPECT_EQ(jumps[0].kind, Jump::Kind::pop);
        // Blocks of 8 pixels that it covers enough of.
        EXPECT_GE(jumps[0].region.x, 40);
        EXPECT_LE(jumps[0].region.x + jumps[0].region.width, 80);
        EXPECT_GE(jumps[0].region.y, 24);
        EXPECT_LE(jumps[0].region.y + jumps[0].region.height, 56);
    }
}

TEST(JumpFinder, AStepIsFoundWhereThePictureStays) {
    const auto later = jumps_of([](int number, image::Image& frame) {
        if (number >= 8) frame = clean_frame(number + 4);
    });
    ASSERT_EQ(later.size(), 1U);
    EXPECT_EQ(later[0].frame, 8);
    EXPECT_EQ(later[0].kind, Jump::Kind::step);

    const auto object = jumps_of([](int number, image::Image& frame) {
        if (number >= 8) test::scale(frame, 0, 40, 24, 32, 32);
    });
    ASSERT_FALSE(object.empty());
    EXPECT_EQ(object[0].frame, 8);
    EXPECT_EQ(object.size(), 1U);
}

TEST(JumpFinder, OddEndsAreFoundAsSteps) {
    for (const int at : {1, kFrames}) {
        const auto jumps = jumps_of([&](int number, image::Image& frame) {
            if (number == at) test::scale(frame, 2);
        });
        ASSERT_EQ(jumps.size(), 1U);
        EXPECT_EQ(jumps[0].frame, at == 1 ? 2 : kFrames);  // the change into the frame
        EXPECT_EQ(jumps[0].kind, Jump::Kind::step);
    }
}

TEST(JumpFinder, AClipWithoutLightHasNoJumps) {
    // v = I / (I + 0) is 1 wherever there is any light.
    JumpFinder finder(test::kWidth, test::kHeight, 0);
    for (int number = 1; number <= kFrames; ++number) {
        image::Image frame = clean_frame(number);
        if (number < 8) test::scale(frame, 0);
        finder.add(number, picture_of(frame), nullptr);
    }
    EXPECT_THAT(finder.finish(), IsEmpty());
}

TEST(JumpFinder, WithAReferenceWhatBothShowIsNoJump) {
    JumpFinder finder(test::kWidth, test::kHeight, 0.4);
    for (int number = 1; number <= kFrames; ++number) {
        image::Image reference = clean_frame(number);
        if (number == 5) test::scale(reference, 3);
        image::Image frame = reference;
        if (number == 11) test::scale(frame, 1.1, 40, 30, 24, 24);  // too faint to be seen without it
        const metrics::Picture expected = picture_of(reference);
        finder.add(number, picture_of(frame), &expected);
    }
    const std::vector<Jump> jumps = finder.finish();
    ASSERT_EQ(jumps.size(), 1U);
    EXPECT_EQ(jumps[0].frame, 11);
    EXPECT_EQ(jumps[0].kind, Jump::Kind::pop);
}

TEST(Shift, IsTold) {
    const metrics::Picture reference = picture_of(clean_frame(3));
    for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, {0.0, -1.0}, {2.0, 3.0}, {-1.4, 0.8}, {7.0, -6.0}}) {
        // The mean square of this pattern is not quite a parabola: between pixels it is told to a fifth.
        const double tolerance = dx == std::round(dx) ? 0.1 : 0.2;
        const auto shift = find_shift(picture_of(clean_frame(3, dx, dy)), reference, 0.4);
        ASSERT_TRUE(shift.has_value()) << dx << " " << dy;
        EXPECT_NEAR(shift->dx, dx, tolerance);
        EXPECT_NEAR(shift->dy, dy, tolerance);
    }
}

TEST(Shift, EqualBrighterOrOtherPicturesAreNotShifted) {
    const metrics::Picture reference = picture_of(clean_frame(3));
    EXPECT_FALSE(find_shift(reference, reference, 0.4).has_value());
    image::Image brighter = clean_frame(3);
    test::scale(brighter, 1.3);
    EXPECT_FALSE(find_shift(picture_of(brighter), reference, 0.4).has_value());
    EXPECT_FALSE(find_shift(picture_of(clean_frame(3, 0.2, 0)), reference, 0.4).has_value());
}

std::vector<std::pair<std::int64_t, double>> series(int count, const std::function<double(int)>& value) {
    std::vector<std::pair<std::int64_t, double>> errors;
    for (int i = 0; i < count; ++i) errors.emplace_back(i + 1, value(i));
    return errors;
}

TEST(Drift, IsTheSlopeOfTheErrors) {
    const auto noise = [](int i) { return hash_uniform(7, 0, static_cast<std::uint64_t>(i), 0) - 0.5; };
    const auto drift = find_drift(series(48, [&](int i) { return 1e-3 * i + 1e-3 * noise(i); }), {});
    ASSERT_TRUE(drift.has_value());
    // The slope's uncertainty is 1e-3 sqrt(1/12) / sqrt(48^3 / 12) = 3e-6.
    EXPECT_NEAR(drift->per_frame, 1e-3, 1e-5);
    EXPECT_NEAR(drift->total, 0.047, 5e-4);
    EXPECT_TRUE(find_drift(series(16, [](int i) { return -5e-4 * i; }), {}).has_value());
    EXPECT_FALSE(find_drift(series(15, [](int i) { return -5e-4 * i; }), {}).has_value());
}

TEST(Drift, ScatterWavesAndStepsAreNone) {
    const auto noise = [](int i) { return hash_uniform(9, 0, static_cast<std::uint64_t>(i), 0) - 0.5; };
    EXPECT_FALSE(find_drift(series(48, [&](int i) { return 0.05 * noise(i); }), {}).has_value());
    EXPECT_FALSE(find_drift(series(48, [](int i) { return 0.02 * std::sin(0.3 * i); }), {}).has_value());
    // One whole period has a line through it, and residuals that last.
    EXPECT_FALSE(find_drift(series(48, [](int i) { return 0.02 * std::sin(0.13 * i); }), {}).has_value());
    EXPECT_FALSE(find_drift(series(48, [](int i) { return 1e-5 * i; }), {}).has_value());  // below the floor
}

TEST(Drift, OneSeriesOfAHundredOfScatterThatLastsIsOneAtMost) {
    // e_t = r e_(t-1) + sqrt(1 - r^2) w_t, w uniform of variance 1.
    constexpr int kSeries = 4000;
    for (const double r : {0.0, 0.5, 0.9}) {
        for (const int count : {16, 24, 48}) {
            int drifts = 0;
            for (std::uint64_t k = 0; k < kSeries; ++k) {
                double e = 0;
                // 60 values before the first let e forget its beginning.
                const auto value = [&](std::uint64_t i) {
                    e = r * e + std::sqrt(12 * (1 - r * r)) * (hash_uniform(13, k, i, 0) - 0.5);
                    return e;
                };
                for (std::uint64_t i = 0; i < 60; ++i) value(i);
                const auto scatter =
                    series(count, [&](int i) { return value(60 + static_cast<std::uint64_t>(i)); });
                drifts += find_drift(scatter, {}).has_value() ? 1 : 0;
            }
            // Expected are 0.5 % at most: 1 % is 40 of 4000, 4 standard deviations above 20.
            EXPECT_LE(drifts, kSeries / 100) << r << " " << count;
        }
    }
}

TEST(Drift, AJumpIsTakenOut) {
    const auto errors = series(48, [](int i) { return 1e-3 * i + (i < 20 ? 0.0 : -0.1); });
    const auto drift = find_drift(errors, {21});
    ASSERT_TRUE(drift.has_value());
    // The jump's frame takes its own part of the drift with it: 1 of 47 steps.
    EXPECT_NEAR(drift->per_frame, 1e-3, 5e-5);
    EXPECT_FALSE(find_drift(series(48, [](int i) { return i < 20 ? 0.0 : 0.1; }), {21}).has_value());
}

}  // namespace
}  // namespace dapple::judge
