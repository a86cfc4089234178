#include "metrics/flicker_track.h"

#include <gtest/gtest.h>

#include "metrics/pictures.h"

namespace dapple::metrics {
namespace {

/// Values that floats hold exactly.
Picture grey(float value) {
    return testing_pictures::picture_by(5, 4, [&](int, int) { return glm::vec3(value); });
}

TEST(FlickerTrack, IsWhatThreeNeighboursSay) {
    FlickerTrack track;
    const float values[] = {1, 2, 1, 4};
    for (int t = 0; t < 4; ++t) track.add(t - 1, grey(values[t]));
    ASSERT_EQ(track.frames().size(), 4u);
    EXPECT_EQ(track.frames().at(-1), lone_frame(grey(1)));
    EXPECT_EQ(track.frames().at(0), frame_flicker(grey(1), grey(2), grey(1)));
    EXPECT_EQ(track.frames().at(1), frame_flicker(grey(2), grey(1), grey(4)));
    EXPECT_EQ(track.frames().at(2), lone_frame(grey(4)));
    // H is 1 and -2; the mean is 2.
    EXPECT_DOUBLE_EQ(track.clip().mean, 2);
    EXPECT_DOUBLE_EQ(track.clip().flicker, (1.0 + 4.0) / 2 / 4);
}

TEST(FlickerTrack, TellsNothingAcrossAGap) {
    FlickerTrack track;
    for (const std::int64_t frame : {1, 2, 4, 5, 6, 9}) track.add(frame, grey(frame % 2 == 0 ? 1.0f : 3.0f));
    for (const std::int64_t frame : {1, 2, 4, 6, 9})
        EXPECT_TRUE(track.frames().at(frame).histogram.empty()) << frame;
    EXPECT_EQ(track.frames().at(5), frame_flicker(grey(1), grey(3), grey(1)));
    EXPECT_EQ(track.clip().frames.size(), 1u);
}

TEST(FlickerTrack, JudgesTheDifferenceByTheMeanOfThePicture) {
    // I - R is 0, 1, 0; I is 4, 5, 3 with the mean 4, R 4, 4, 3.
    FlickerTrack track;
    track.add(1, grey(4), grey(4));
    track.add(2, grey(5), grey(4));
    track.add(3, grey(3), grey(3));
    EXPECT_EQ(track.frames().at(2), frame_flicker(grey(4), grey(5), grey(3), grey(4), grey(4), grey(3)));
    EXPECT_DOUBLE_EQ(track.clip().flicker, 1.0 / 16);
}

}  // namespace
}  // namespace dapple::metrics
