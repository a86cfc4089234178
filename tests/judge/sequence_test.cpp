#include "judge/sequence.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "image/temporary_folder.h"
#include "run/manifest.h"

namespace dapple::judge {
namespace {

using dapple::test::TemporaryFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class FindSequence : public testing::Test {
protected:
    void make(const std::vector<std::string>& names) const {
        for (const std::string& name : names) {
            std::filesystem::create_directories(std::filesystem::path(folder / name).parent_path());
            std::ofstream(folder / name) << "x";
        }
    }
    static std::vector<std::int64_t> frames(const Sequence& sequence) {
        std::vector<std::int64_t> numbers;
        for (const auto& [number, path] : sequence.files) numbers.push_back(number);
        return numbers;
    }
    /// The message; it is an input that is unreadable, in one short line.
    static std::string failure_of(const std::string& specification) {
        try {
            find_sequence(specification);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::input_unreadable);
            EXPECT_LE(std::string(error.what()).size(), 1024U);
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            return error.what();
        }
        return {};
    }
    TemporaryFolder folder;
};

TEST_F(FindSequence, ByPatternTakesWhatPrintfWouldWrite) {
    make({"a.0001.exr", "a.0010.exr", "a.12345.exr", "a.-001.exr", "a.1.exr", "a.00011.exr", "b.0003.exr",
          "a.0002.png", ".a.0004.exr.host.1.tmp"});
    const std::vector<std::int64_t> expected{-1, 1, 10, 12345};
    EXPECT_EQ(frames(find_sequence(folder / "a.%04d.exr")), expected);
    EXPECT_EQ(frames(find_sequence(folder / "a.####.exr")), expected);
    EXPECT_THAT(frames(find_sequence(folder / "a.%d.exr")), ElementsAre(1, 12345));
    EXPECT_EQ(find_sequence(folder / "a.%04d.exr").first, -1);
    EXPECT_EQ(find_sequence(folder / "a.%04d.exr").last, 12345);
    EXPECT_THAT(failure_of(folder / "c.%04d.exr"), AllOf(HasSubstr("c.%04d.exr"), HasSubstr("a.0001.exr")));
    EXPECT_THAT(failure_of(folder / "none/c.%04d.exr"), HasSubstr("there is no"));
}

TEST_F(FindSequence, InAFolderTheLastDigitsAreTheNumber) {
    make({"dot/shot2.v01.0001.exr", "dot/shot2.v01.0003.exr", "under/s_7.EXR", "under/s_-3.EXR",
          "minus/s-7.png", "minus/s-8.png", "bare/0001.exr", "bare/-2.exr"});
    EXPECT_THAT(frames(find_sequence(folder / "dot")), ElementsAre(1, 3));
    EXPECT_THAT(frames(find_sequence(folder / "under")), ElementsAre(-3, 7));
    EXPECT_THAT(frames(find_sequence(folder / "minus")), ElementsAre(7, 8));
    EXPECT_THAT(frames(find_sequence(folder / "bare")), ElementsAre(-2, 1));
}

TEST_F(FindSequence, AFolderOfNoneOrOfSeveralNamesWhatIsThere) {
    make({"two/a.0001.exr", "two/b.01.exr", "none/notes.txt", "none/still.exr", "twice/a.1.exr",
          "twice/a.01.exr", "far/a.1.exr", "far/a.2000000000.exr"});
    EXPECT_THAT(failure_of(folder / "two"), AllOf(HasSubstr("a.%04d.exr"), HasSubstr("b.%02d.exr")));
    EXPECT_THAT(failure_of(folder / "none"), AllOf(HasSubstr("notes.txt"), HasSubstr("still.exr")));
    EXPECT_THAT(failure_of(folder / "twice"), HasSubstr("frame 1 is there twice"));
    EXPECT_THAT(failure_of(folder / "far"), HasSubstr("2000000000"));
    EXPECT_THAT(failure_of(folder / "nowhere"), HasSubstr("there is no"));
    EXPECT_THAT(failure_of(""), HasSubstr("empty"));
    EXPECT_THAT(failure_of(folder / "none/notes.txt"), HasSubstr("neither"));
}

TEST_F(FindSequence, OnePictureIsASequenceOfItsNumber) {
    make({"a.0012.exr", "still.png"});
    EXPECT_THAT(frames(find_sequence(folder / "a.0012.exr")), ElementsAre(12));
    EXPECT_THAT(frames(find_sequence(folder / "still.png")), ElementsAre(0));
}

TEST_F(FindSequence, AManifestSaysWhatIsExpected) {
    run::Manifest manifest;
    manifest.job_hash = "job";
    manifest.clip.name = "pool";
    manifest.clip.fps = {24, 1};
    manifest.clip.first_frame = -1;
    manifest.clip.last_frame = 3;
    manifest.frames[-1] = {{10, "ten"}, {20, "twenty"}, 0, {}};
    manifest.frames[2] = {{11, "eleven"}, {21, "one"}, 0, {}};
    manifest.frames[3] = {{12, "twelve"}, {22, "two"}, 0, {}};
    run::write_manifest(folder / "manifest.json", manifest);
    make({"linear/pool.-001.exr", "linear/pool.0001.exr", "linear/pool.0002.exr", "graded/pool.0003.exr"});

    for (const std::string& name : {folder.path(), folder / "manifest.json"}) {
        const Sequence sequence = find_sequence(name);
        EXPECT_THAT(frames(sequence), ElementsAre(-1, 2));  // 1 is not entered, so it does not exist
        EXPECT_EQ(sequence.first, -1);
        EXPECT_EQ(sequence.last, 3);
        EXPECT_EQ(sequence.fps, 24.0);
        EXPECT_EQ(sequence.expected.at(2).content_hash, "eleven");
        EXPECT_EQ(sequence.expected.at(3).bytes, 12U);
    }
    const Sequence graded = find_sequence(folder.path(), Pictures::graded);
    EXPECT_THAT(frames(graded), ElementsAre(3));
    EXPECT_EQ(graded.expected.at(3).content_hash, "two");
}

TEST_F(FindSequence, AManifestOfNoClipIsRefused) {
    const auto failure = [&](std::int64_t first, std::int64_t last, scene::Rational fps) {
        run::Manifest manifest;
        manifest.clip.name = "pool";
        manifest.clip.fps = fps;
        manifest.clip.first_frame = first;
        manifest.clip.last_frame = last;
        run::write_manifest(folder / "manifest.json", manifest);
        return failure_of(folder / "manifest.json");
    };
    constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
    EXPECT_THAT(failure(0, most, {24, 1}), HasSubstr("no clip"));
    EXPECT_THAT(failure(-most, most, {24, 1}), HasSubstr("no clip"));  // the length overflows
    EXPECT_THAT(failure(5, 4, {24, 1}), HasSubstr("no clip"));
    EXPECT_THAT(failure(1, 4, {0, 0}), HasSubstr("no frame rate"));
    EXPECT_THAT(failure(1, 4, {24, 0}), HasSubstr("no frame rate"));
    EXPECT_THAT(failure(1, 4, {-24, 1}), HasSubstr("no frame rate"));
    EXPECT_THAT(failure(1, 4, {24, 1}), HasSubstr("none of the clip's frames"));
}

TEST_F(FindSequence, SequencesFarApartAreNotJudgedTogether) {
    make({"a/a.1.exr", "a/a.5.exr", "b/b.20240101.exr"});
    const Sequence a = find_sequence(folder / "a"), b = find_sequence(folder / "b");
    EXPECT_THAT(all_frames({a}), ElementsAre(1, 2, 3, 4, 5));
    try {
        all_frames({a, b});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        EXPECT_THAT(error.what(), AllOf(HasSubstr("20240101"), HasSubstr("at most")));
    }
}

TEST_F(FindSequence, AnotherProgramsManifestDoesNotHidePictures) {
    make({"manifest.json", "a.1.exr", "broken/manifest.json"});
    EXPECT_THAT(frames(find_sequence(folder.path())), ElementsAre(1));
    EXPECT_THAT(failure_of(folder / "broken"), HasSubstr("no manifest of dapple"));
    EXPECT_THAT(failure_of(folder / "manifest.json"), HasSubstr("no manifest of dapple"));
}

}  // namespace
}  // namespace dapple::judge
