#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "base/hash.h"
#include "image/png.h"
#include "image/temporary_folder.h"
#include "judge/sequence_reader.h"
#include "judge/synthetic_clip.h"

namespace dapple::judge {
namespace {

using dapple::test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

std::vector<ReadFrame> read_all(const std::string& specification, const ReadOptions& options = {}) {
    SequenceReader reader({find_sequence(specification)}, options);
    std::vector<ReadFrame> frames;
    for (auto step = reader.next(); !step.empty(); step = reader.next()) frames.push_back(std::move(step[0]));
    return frames;
}

TEST(SequenceReader, GivesFramesInOrderAndSaysWhichAreMissing) {
    const TemporaryFolder folder;
    test::write_clip(folder.path(), 4);
    std::filesystem::remove(test::frame_path(folder.path(), 3));
    ReadOptions options;
    options.content_hash = true;
    const std::vector<ReadFrame> frames = read_all(folder.path(), options);
    ASSERT_EQ(frames.size(), 4U);
    for (int i = 0; i < 4; ++i) {
        const ReadFrame& frame = frames[static_cast<std::size_t>(i)];
        EXPECT_EQ(frame.frame, i + 1);
        EXPECT_EQ(frame.missing, i == 2);
        ASSERT_EQ(frame.picture.has_value(), i != 2);
        if (i == 2) continue;
        EXPECT_EQ(frame.picture->rgb[1][77], test::clean_frame(i + 1).channels[1].values[77]);
        const std::vector<char> bytes = test::bytes_of(frame.path);
        EXPECT_EQ(frame.bytes, bytes.size());
        EXPECT_EQ(frame.content_hash, content_hash(bytes.data(), bytes.size()));
        EXPECT_FALSE(frame.display_referred);
    }
}

TEST(SequenceReader, ReadsAllSequencesTogetherAndEndsEarlyWithoutHanging) {
    const TemporaryFolder a, b;
    test::write_clip(a.path(), 3);
    test::write_clip(b.path(), 5);
    SequenceReader reader({find_sequence(a.path()), find_sequence(b.path())}, {});
    for (int i = 1; i <= 5; ++i) {
        const std::vector<ReadFrame> step = reader.next();
        ASSERT_EQ(step.size(), 2U);
        EXPECT_EQ(step[0].picture.has_value(), i <= 3);
        EXPECT_TRUE(step[1].picture.has_value());
    }
    EXPECT_TRUE(reader.next().empty());
    EXPECT_TRUE(reader.next().empty());
    EXPECT_GT(reader.decode_cpu_s(), 0);
    const SequenceReader unread({find_sequence(b.path())}, {});  // its thread waits when it is destroyed
}

TEST(SequenceReader, WhatCannotBeReadIsAFault) {
    const TemporaryFolder folder;
    test::write_clip(folder.path(), 6);
    std::vector<char> bytes = test::bytes_of(test::frame_path(folder.path(), 2));
    bytes.resize(bytes.size() / 2);
    test::write_bytes(test::frame_path(folder.path(), 2), bytes);
    test::write_bytes(test::frame_path(folder.path(), 3), {});
    image::Image small;
    small.width = 16;
    small.height = 8;
    for (const char* name : {"R", "G", "B"}) small.add(name);
    test::write_raw(test::frame_path(folder.path(), 4), small);
    image::Image depth = test::clean_frame(5);
    depth.channels.erase(depth.channels.begin(), depth.channels.begin() + 2);
    depth.channels[0].name = "Z";
    test::write_raw(test::frame_path(folder.path(), 5), depth);

    const std::vector<ReadFrame> frames = read_all(folder.path());
    EXPECT_THAT(frames[1].fault, HasSubstr("clip.0002.exr"));
    EXPECT_THAT(frames[2].fault, HasSubstr("clip.0003.exr"));
    EXPECT_THAT(frames[3].fault, AllOf(HasSubstr("16 x 8"), HasSubstr("120 x 72")));
    EXPECT_THAT(frames[4].fault, AllOf(HasSubstr("no layer"), HasSubstr("Z")));
    EXPECT_TRUE(frames[5].picture.has_value());
    for (const ReadFrame& frame : frames) {
        EXPECT_EQ(frame.picture.has_value(), frame.fault.empty());
        EXPECT_LE(frame.fault.size(), 1024U);
        EXPECT_EQ(frame.fault.find('\n'), std::string::npos);
    }
}

TEST(SequenceReader, TheSizeThatIsAskedForIsTheRightOne) {
    const TemporaryFolder folder;
    test::write_clip(folder.path(), 3);
    image::Image small;
    small.width = 16;
    small.height = 8;
    for (const char* name : {"R", "G", "B"}) small.add(name);
    test::write_raw(test::frame_path(folder.path(), 1), small);
    image::write_png(folder / "png.0001.png", 16, 8, std::vector<std::uint8_t>(16 * 8 * 3));
    ReadOptions options;
    options.size = {test::kWidth, test::kHeight};
    const std::vector<ReadFrame> frames = read_all(folder / "clip.%04d.exr", options);
    EXPECT_THAT(frames[0].fault, AllOf(HasSubstr("16 x 8"), HasSubstr("120 x 72")));
    EXPECT_TRUE(frames[1].picture.has_value()) << frames[1].fault;
    EXPECT_THAT(read_all(folder / "png.0001.png", options)[0].fault, HasSubstr("120 x 72"));
}

TEST(SequenceReader, ReadsOneStepAheadAndNoMore) {
    const TemporaryFolder folder;
    test::write_clip(folder.path(), 4);
    SequenceReader reader({find_sequence(folder.path())}, {});
    EXPECT_TRUE(reader.next()[0].picture.has_value());
    // Reading a frame takes a millisecond: a reader that goes on to the third one has done so by then.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    std::filesystem::remove(test::frame_path(folder.path(), 2));
    std::filesystem::remove(test::frame_path(folder.path(), 3));
    EXPECT_TRUE(reader.next()[0].picture.has_value());  // was read ahead
    EXPECT_TRUE(reader.next()[0].missing);
    EXPECT_TRUE(reader.next()[0].picture.has_value());
}

TEST(SequenceReader, PngAndGradedPicturesAreDisplayReferred) {
    const TemporaryFolder folder;
    std::vector<std::uint8_t> rgb(16 * 16 * 3, 51);
    image::write_png(folder / "a.1.png", 16, 16, rgb);
    const std::vector<ReadFrame> png = read_all(folder / "a.1.png");
    ASSERT_TRUE(png[0].picture.has_value());
    EXPECT_TRUE(png[0].display_referred);
    EXPECT_FLOAT_EQ(png[0].picture->rgb[2][5], 0.2f);

    image::Image graded = test::clean_frame(1);
    graded.metadata.emplace_back("dapple:ocio_view", "view");
    image::write_exr_verified(folder / "b.1.exr", graded);
    EXPECT_TRUE(read_all(folder / "b.1.exr")[0].display_referred);
}

TEST(SequenceReader, ReadsLayersMotionAndPrimaries) {
    const TemporaryFolder folder;
    image::Image frame = test::clean_frame(1);
    for (const char* name : {"caustics.R", "caustics.G", "caustics.B"}) frame.add(name).values[9] = 4;
    frame.add("flow.X").values[9] = -2;
    frame.add("flow.Y").values[9] = 3;
    image::ExrOptions wide;
    wide.chromaticities = image::kAcesCgChromaticities;
    image::write_exr_verified(folder / "a.1.exr", frame, wide);
    ReadOptions options;
    options.layer = "caustics";
    options.motion_layer = "flow";
    std::vector<ReadFrame> frames = read_all(folder / "a.1.exr", options);
    ASSERT_TRUE(frames[0].picture.has_value()) << frames[0].fault;
    EXPECT_EQ(frames[0].picture->rgb[0][9], 4);
    EXPECT_EQ(frames[0].motion->x[9], -2);
    EXPECT_EQ(frames[0].motion->y[9], 3);
    EXPECT_EQ(frames[0].chromaticities, image::kAcesCgChromaticities);
    // Equal channels are white, which stays equal channels in any primaries.
    to_rec709(frames[0]);
    EXPECT_NEAR(frames[0].picture->rgb[0][9], 4, 1e-4);
    EXPECT_NEAR(frames[0].picture->rgb[2][9], 4, 1e-4);

    options.motion_layer = "none";
    EXPECT_THAT(read_all(folder / "a.1.exr", options)[0].fault, HasSubstr("none.X"));
}

}  // namespace
}  // namespace dapple::judge
