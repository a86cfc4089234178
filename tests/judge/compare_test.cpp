// The files that compare writes.
#include "judge/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/checked_file.h"
#include "base/error.h"
#include "image/png.h"
#include "judge/compare_scene.h"
#include "run/child_process.h"
#include "run/interruption.h"

namespace dapple::judge {
namespace {

using testing::HasSubstr;
using testing_tools::file_text;
using testing_tools::run_program;
using testing_tools::ScratchFolder;

class CompareTest : public testing::Test {
protected:
    CompareTest() {
        options.sequences = {write_clip(folder, "a", 65, 37, {1, 2, 3, 4, 5, 6, 7}, busy),
                             write_clip(folder, "b", 65, 37, {1, 2, 3, 5, 6, 7},
                                        [](int x, int y, int frame) { return 1.1f * busy(x, y, frame); })};
        options.video = folder / "out.mp4";
        options.sheet = folder / "out.png";
        options.sheet_frames = 3;
    }

    CompareEnd run() {
        notes.clear();
        CompareListener listener = silent();
        listener.note = [this](const std::string& line) { notes += line + "\n"; };
        listener.stop = [this] { return stop_after > 0 && --stop_after == 0; };
        return compare(options, listener);
    }
    std::vector<std::string> left() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder / ".")) {
            if (entry.path().extension() != ".exr") names.push_back(entry.path().filename().string());
        }
        return names;
    }

    const run::Interruption interruption;  // ignores SIGPIPE
    ScratchFolder folder;
    CompareOptions options;
    std::string notes;
    int stop_after = 0;
};

TEST_F(CompareTest, TheVideoHasItsFramesRateSizeAndTags) {
    options.fps = exact_rate(23.976);
    ASSERT_EQ(run(), CompareEnd::done);
    const Layout layout = plan_layout(65, 37, 2, 7, {});
    const auto even = [](int size) { return std::to_string(size + size % 2); };
    const char* const entries =
        "stream=codec_name,pix_fmt,width,height,r_frame_rate,nb_read_frames,color_range,color_space,color_"
        "transfer,"
        "color_primaries";
    const auto probe = run_program({"ffprobe", "-v", "error", "-count_frames", "-show_entries", entries,
                                    "-of", "default=noprint_wrappers=1", options.video},
                                   folder / "probe");
    for (const std::string& expected :
         {std::string("codec_name=h264"), std::string("pix_fmt=yuv420p"), "width=" + even(layout.width),
          "height=" + even(layout.height), std::string("r_frame_rate=24000/1001"),
          std::string("nb_read_frames=7"), std::string("color_range=tv"), std::string("color_space=bt709"),
          std::string("color_transfer=bt709"), std::string("color_primaries=bt709")}) {
        EXPECT_THAT(probe.output, HasSubstr(expected));
    }
    EXPECT_THAT(notes, HasSubstr("comparing 7 frames (1-7) of 65 x 37: A a.%04d.exr, B b.%04d.exr"));
    EXPECT_THAT(notes, HasSubstr("B: 1 frame missing, drawn as blanks: 4"));
    EXPECT_THAT(notes, HasSubstr("out.mp4: 7 frames"));
}

TEST_F(CompareTest, TheSheetHasAColumnForEachPickedFrame) {
    options.video = "";
    ASSERT_EQ(run(), CompareEnd::done);
    const image::CodeValues sheet = image::decode_png(read_whole_file(options.sheet), "sheet");
    // Three columns of pictures enlarged to 195 and gaps of 10, at least 640; rows of A, B and |A - B|.
    EXPECT_EQ(sheet.width, 640);
    EXPECT_EQ(sheet.height, 34 + 24 + 3 * (30 + 37 * 3 + 10));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.mp4"));
}

TEST_F(CompareTest, TheSameSequencesMakeTheSameBytes) {
    ASSERT_EQ(run(), CompareEnd::done);
    const std::string video = file_text(options.video), sheet = file_text(options.sheet);
    ASSERT_EQ(run(), CompareEnd::done);
    EXPECT_TRUE(file_text(options.video) == video);
    EXPECT_TRUE(file_text(options.sheet) == sheet);
}

TEST_F(CompareTest, StoppedItLeavesNothing) {
    for (const int calls : {3, 7 + 2}) {  // in the first reading and in the second
        stop_after = calls;
        EXPECT_EQ(run(), CompareEnd::stopped) << calls;
        EXPECT_THAT(left(), testing::IsEmpty()) << calls;
    }
}

TEST_F(CompareTest, ADamagedFrameIsABlankAndToldAtTheEnd) {
    const std::string path = folder / "a.0002.exr";
    options.video = "";
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    ASSERT_EQ(run(), CompareEnd::done);
    EXPECT_THAT(notes, HasSubstr("A: 1 frame unreadable, drawn as blanks: 2; the first: " + path));
}

TEST_F(CompareTest, AFrameOfAnotherSizeIsABlankWhereTheSheetPicksItAlone) {
    write_clip(folder, "a", 9, 5, {4}, busy);  // over the one of 65 x 37, the middle frame
    options.video = "";
    options.sheet_frames = 1;
    ASSERT_EQ(run(), CompareEnd::done);
    EXPECT_THAT(notes, HasSubstr("A: 1 frame unreadable, drawn as blanks: 4"));
}

TEST_F(CompareTest, WhatCannotBeWrittenIsKnownBeforeReading) {
    const auto code = [&] {
        try {
            run();
        } catch (const Error& error) {
            return error.code();
        }
        return ExitCode::done;
    };
    options.video = folder / "no_folder/out.mp4";
    EXPECT_EQ(code(), ExitCode::output_unwritable);
    EXPECT_EQ(notes, "");
    options.video = folder / ".";
    EXPECT_EQ(code(), ExitCode::output_unwritable);
    options.video = options.sheet;
    EXPECT_EQ(code(), ExitCode::usage);
    options.video = options.sheet = "";
    EXPECT_EQ(code(), ExitCode::usage);
    EXPECT_THAT(left(), testing::IsEmpty());
}

}  // namespace
}  // namespace dapple::judge
