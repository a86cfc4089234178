#include "run/frame_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <nlohmann/json.hpp>

#include "run/frame_loop_fixture.h"
#include "run/manifest.h"
#include "run/output_paths.h"
#include "run/stats_file.h"

namespace dapple::run {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing_tools::file_text;
using testing_tools::pictures_in;
using testing_tools::ScratchFolder;

TEST_F(FrameLoopTest, FilesHaveTheSameBytesInAnyRangeOrderAndNumberOfThreads) {
    ASSERT_EQ(render(scratch / "whole", "1-6"), ExitCode::done);
    const auto whole = pictures_in(scratch / "whole");
    ASSERT_THAT(whole, SizeIs(12));
    EXPECT_TRUE(whole.contains("linear/fake.0003.exr"));
    EXPECT_TRUE(whole.contains("graded/fake.0003.exr"));
    ASSERT_NE(whole.at("linear/fake.0003.exr"), whole.at("linear/fake.0004.exr"));

    ASSERT_EQ(render(scratch / "alone", "3"), ExitCode::done);
    const auto alone = pictures_in(scratch / "alone");
    ASSERT_THAT(alone, SizeIs(2));
    EXPECT_EQ(alone.at("linear/fake.0003.exr"), whole.at("linear/fake.0003.exr"));
    EXPECT_EQ(alone.at("graded/fake.0003.exr"), whole.at("graded/fake.0003.exr"));

    ASSERT_EQ(render(scratch / "reversed", "6-1"), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(6, 5, 4, 3, 2, 1));
    EXPECT_TRUE(pictures_in(scratch / "reversed") == whole);

    for (const int threads : {1, 2}) {
        set_thread_count(threads);
        image::set_exr_threads(threads);
        ASSERT_EQ(render(scratch / "threads", "1-6", Existing::overwrite), ExitCode::done);
        EXPECT_TRUE(pictures_in(scratch / "threads") == whole) << threads;
    }
    set_thread_count(0);
}

TEST_F(FrameLoopTest, ManifestDescribesTheFiles) {
    ASSERT_EQ(render(scratch / "out", "2,4"), ExitCode::done);
    const auto manifest = read_manifest(scratch / "out/manifest.json");
    ASSERT_TRUE(manifest.has_value());
    EXPECT_EQ(manifest->job_hash, fake_job().hash());
    EXPECT_EQ(manifest->parts, fake_job().parts);
    EXPECT_EQ(manifest->provenance, fake_job().provenance);
    EXPECT_EQ(manifest->clip.fps.numerator, 24000);
    EXPECT_EQ(manifest->clip.fps.denominator, 1001);
    EXPECT_EQ(manifest->clip.last_frame, 6);
    ASSERT_THAT(manifest->frames, SizeIs(2));
    for (const std::int64_t frame : {2, 4}) {
        const FrameEntry& entry = manifest->frames.at(frame);
        const std::string name = "/fake.000" + std::to_string(frame) + ".exr";
        EXPECT_TRUE(matches(scratch / "out/linear" + name, entry.linear, true));
        EXPECT_TRUE(matches(scratch / "out/graded" + name, entry.graded, true));
        EXPECT_EQ(content_hash(file_text(scratch / "out/graded" + name)), entry.graded.content_hash);
    }
}

TEST_F(FrameLoopTest, ResumeKeepsFinishedFrames) {
    ASSERT_EQ(render(scratch / "out", "2-3"), ExitCode::done);
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(1, 4, 5, 6));
    EXPECT_THAT(out, HasSubstr("4 frames rendered, 2 kept"));
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_THAT(source.rendered, IsEmpty());
    ASSERT_EQ(render(scratch / "out", "2", Existing::overwrite), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(2));
    EXPECT_THAT(read_manifest(scratch / "out/manifest.json")->frames, SizeIs(6));
}

TEST_F(FrameLoopTest, VerifyFindsDamageThatSkipDoesNot) {
    ASSERT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    const auto whole = pictures_in(scratch / "out");
    {
        std::fstream file(scratch / "out/graded/fake.0002.exr",
                          std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-1, std::ios::end);
        file.put('!');
    }
    std::filesystem::resize_file(scratch / "out/linear/fake.0005.exr", 100);
    std::filesystem::remove(scratch / "out/linear/fake.0006.exr");
    ASSERT_FALSE(pictures_in(scratch / "out") == whole);

    ASSERT_EQ(render(scratch / "out", "1-6", Existing::skip), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(5, 6));
    ASSERT_EQ(render(scratch / "out", "1-6", Existing::verify), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(2));
    EXPECT_TRUE(pictures_in(scratch / "out") == whole);
}

TEST_F(FrameLoopTest, FramesThatTheManifestDoesNotKnowAreRenderedAgain) {
    ASSERT_EQ(render(scratch / "out", "1-2"), ExitCode::done);
    std::filesystem::remove(scratch / "out/manifest.json");
    ASSERT_EQ(render(scratch / "out", "1-2", Existing::skip), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(1, 2));
}

TEST_F(FrameLoopTest, AnotherJobsFolderIsLeftAlone) {
    ASSERT_EQ(render(scratch / "out", "1-2"), ExitCode::done);
    const std::string manifest = file_text(scratch / "out/manifest.json");
    for (const Existing existing : {Existing::verify, Existing::skip, Existing::error}) {
        EXPECT_EQ(render(scratch / "out", "1-2", existing, fake_job("b")), ExitCode::usage);
        EXPECT_THAT(message, HasSubstr("frames of another job (other: the timeline)"));
        EXPECT_THAT(message, HasSubstr("--existing overwrite"));
        EXPECT_EQ(file_text(scratch / "out/manifest.json"), manifest);
    }
    EXPECT_EQ(render(scratch / "out", "1", Existing::overwrite, fake_job("b")), ExitCode::done);
    EXPECT_THAT(read_manifest(scratch / "out/manifest.json")->frames, SizeIs(1));
    EXPECT_EQ(render(scratch / "out", "1-2", Existing::verify), ExitCode::usage);
}

TEST_F(FrameLoopTest, AJobThatFailedBeforeItsFirstFrameClaimsNoFolder) {
    source.broken = {1};
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::input_unreadable);
    source.broken = {};
    // The timeline is put right, which makes it another job.
    EXPECT_EQ(render(scratch / "out", "1", Existing::verify, fake_job("b")), ExitCode::done);
    EXPECT_EQ(read_manifest(scratch / "out/manifest.json")->job_hash, fake_job("b").hash());
    EXPECT_EQ(render(scratch / "out", "1"), ExitCode::usage);
}

TEST_F(FrameLoopTest, ADamagedManifestIsNobodysJob) {
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::done);
    for (const char* text : {"", "{", "[]", "{\"format\": 1}", "{\"format\": 2}", "\xff\xfe"}) {
        std::ofstream(scratch / "out/manifest.json") << text;
        EXPECT_EQ(render(scratch / "out", "1"), ExitCode::usage) << text;
        EXPECT_THAT(message, HasSubstr("manifest.json cannot be read"));
        EXPECT_EQ(file_text(scratch / "out/manifest.json"), text);
    }
    EXPECT_EQ(render(scratch / "out", "1", Existing::overwrite), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(1));
}

TEST_F(FrameLoopTest, AnotherMachineGoesOnAndSaysSo) {
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::done);
    Job job = fake_job();
    job.provenance = {{"device", "another"}};
    ASSERT_EQ(render(scratch / "out", "1-2", Existing::verify, job), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(2));
    EXPECT_THAT(warnings, HasSubstr("made with other versions (the device)"));
    ASSERT_EQ(render(scratch / "out", "1-2", Existing::verify, job), ExitCode::done);
    EXPECT_THAT(warnings, IsEmpty());
}

TEST_F(FrameLoopTest, ErrorRefusesAnyExistingFrame) {
    ASSERT_EQ(render(scratch / "out", "1-2", Existing::error), ExitCode::done);
    EXPECT_EQ(render(scratch / "out", "2-3", Existing::error), ExitCode::usage);
    EXPECT_THAT(message, HasSubstr("frame 2 exists"));
    EXPECT_THAT(source.rendered, IsEmpty());
    EXPECT_EQ(render(scratch / "out", "3-4", Existing::error), ExitCode::done);
}

TEST_F(FrameLoopTest, AFolderHasOneWriter) {
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::done);
    const int folder = ::open((scratch / "out").c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(::flock(folder, LOCK_EX | LOCK_NB), 0);
    EXPECT_EQ(render(scratch / "out", "2"), ExitCode::usage);
    EXPECT_THAT(message, HasSubstr("another process is rendering into"));
    ::close(folder);
    EXPECT_EQ(render(scratch / "out", "2"), ExitCode::done);
}

TEST_F(FrameLoopTest, AFrameThatFailsLosesNothingElse) {
    source.broken = {3};
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::input_unreadable);
    EXPECT_THAT(message, HasSubstr("mesh.obj"));
    EXPECT_THAT(read_manifest(scratch / "out/manifest.json")->frames, SizeIs(2));
    source.broken = {};
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_THAT(source.rendered, ElementsAre(3, 4, 5, 6));
}

TEST_F(FrameLoopTest, AFrameThatIsBrokenOffGoesOnFromItsCheckpoint) {
    ASSERT_EQ(render(scratch / "whole", "1-6"), ExitCode::done);
    source.slow = {3};
    source.steps_before_stop = 4;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::interrupted);
    EXPECT_THAT(out, HasSubstr("interrupted; the same command goes on: 2 frames rendered"));
    EXPECT_THAT(read_manifest(scratch / "out/manifest.json")->frames, SizeIs(2));
    EXPECT_THAT(pictures_in(scratch / "out"), SizeIs(4));
    EXPECT_EQ(file_text(scratch / "out/checkpoint/fake.0003.partial"), "4");

    source.steps_before_stop = -1;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
    EXPECT_EQ(source.steps_taken, FakeSource::kSteps);  // none twice
    EXPECT_THAT(source.rendered, ElementsAre(3, 4, 5, 6));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out/checkpoint"));
    EXPECT_TRUE(pictures_in(scratch / "out") == pictures_in(scratch / "whole"));
}

TEST_F(FrameLoopTest, ACheckpointOfAnotherJobIsNotUsed) {
    // The first frame is broken off: the job has a checkpoint, but no frame that would claim the folder.
    const auto leave_checkpoint = [&](const std::string& folder) {
        source.slow = {1};
        source.steps_before_stop = 4;
        ASSERT_EQ(render(folder, "1"), ExitCode::interrupted);
        ASSERT_TRUE(std::filesystem::exists(folder + "/checkpoint/fake.0001.partial"));
        source.steps_before_stop = -1;
        source.steps_taken = 0;
    };
    leave_checkpoint(scratch / "edited");
    EXPECT_EQ(render(scratch / "edited", "1", Existing::verify, fake_job("b")), ExitCode::done);
    EXPECT_EQ(source.steps_taken, FakeSource::kSteps);

    leave_checkpoint(scratch / "overwritten");
    EXPECT_EQ(render(scratch / "overwritten", "1", Existing::overwrite), ExitCode::done);
    EXPECT_EQ(source.steps_taken, FakeSource::kSteps);

    leave_checkpoint(scratch / "manifest lost");
    std::filesystem::remove(scratch / "manifest lost/manifest.json");
    EXPECT_EQ(render(scratch / "manifest lost", "1"), ExitCode::done);
    EXPECT_EQ(source.steps_taken, FakeSource::kSteps);

    leave_checkpoint(scratch / "same");
    EXPECT_EQ(render(scratch / "same", "1"), ExitCode::done);
    EXPECT_EQ(source.steps_taken, FakeSource::kSteps - 4);
}

TEST_F(FrameLoopTest, ACheckpointOfAFinishedFrameGoes) {
    ASSERT_EQ(render(scratch / "out", "1-2"), ExitCode::done);
    std::filesystem::create_directory(scratch / "out/checkpoint");
    for (const char* name : {"fake.0001.partial", "fake.0004.partial", "notes"})
        std::ofstream(scratch / (std::string("out/checkpoint/") + name)) << "9";
    ASSERT_EQ(render(scratch / "out", "1-2"), ExitCode::done);
    EXPECT_FALSE(std::filesystem::exists(scratch / "out/checkpoint/fake.0001.partial"));
    EXPECT_TRUE(std::filesystem::exists(scratch / "out/checkpoint/fake.0004.partial"));
    ASSERT_EQ(render(scratch / "out", "1", Existing::overwrite), ExitCode::done);
    EXPECT_FALSE(std::filesystem::exists(scratch / "out/checkpoint/fake.0004.partial"));
    EXPECT_TRUE(std::filesystem::exists(scratch / "out/checkpoint/notes"));
}

TEST_F(FrameLoopTest, TooMuchMemoryIsRefusedBeforeAnythingIsWritten) {
    options.max_memory = 999;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::out_of_memory_budget);
    EXPECT_THAT(message, HasSubstr("needs about 1000 B of memory, more than the 999 B of --max-memory"));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
    options.max_memory = 1000;
    EXPECT_EQ(render(scratch / "out", "1-6"), ExitCode::done);
}

TEST_F(FrameLoopTest, AFolderThatCannotBeMadeIsAnOutputError) {
    std::ofstream(scratch / "file") << "text";
    EXPECT_EQ(render(scratch / "file/out", "1"), ExitCode::output_unwritable);
    EXPECT_THAT(message, HasSubstr("file/out"));
    EXPECT_THAT(source.rendered, IsEmpty());
    EXPECT_EQ(file_text(scratch / "file"), "text");
}

TEST_F(FrameLoopTest, StatsHaveOneLineAFrameInTheirOrder) {
    ASSERT_EQ(render(scratch / "out", "5,2"), ExitCode::done);
    std::ofstream(scratch / "out/stats.jsonl", std::ios::app)
        << "{\"frame\": 4, \"wall_s\": 1}\n{\"frame\": 2, \"to";
    source.not_finite = {4};
    ASSERT_EQ(render(scratch / "out", "4-6"), ExitCode::done);
    EXPECT_THAT(warnings,
                HasSubstr("frame 4: 1 values were NaN or infinite and are 0 now, the first at R 3,4"));

    source.not_finite = {4, 5};
    ASSERT_EQ(render(scratch / "out", "5", Existing::overwrite), ExitCode::done);

    std::ifstream stream(scratch / "out/stats.jsonl");
    std::vector<std::int64_t> frames;
    for (std::string line; std::getline(stream, line);) {
        const auto json = nlohmann::json::parse(line);
        if (json.contains("clip")) break;
        frames.push_back(json.at("frame").get<std::int64_t>());
        EXPECT_EQ(json.at("non_finite"), source.not_finite.contains(frames.back()) ? 1 : 0);
        EXPECT_EQ(json.at("counts").at("pixels"), 16 * 9);
        EXPECT_EQ(json.at("passes").at(0).at("name"), "noise");
        EXPECT_EQ(json.at("passes").at(1).at("name"), "write");
        EXPECT_EQ(json.at("passes").at(2).at("name"), "temporal figures");
        EXPECT_GE(json.at("wall_s").get<double>(), json.at("passes").at(1).at("wall_s").get<double>());
        EXPECT_GT(json.at("peak_memory").get<double>(), 1e6);
        const auto size = std::filesystem::file_size(scratch / "out/linear/fake.000" +
                                                     std::to_string(frames.back()) + ".exr");
        EXPECT_EQ(json.at("linear").at("bytes"), size);
    }
    EXPECT_THAT(frames, ElementsAre(2, 4, 5, 6));
}

TEST_F(FrameLoopTest, StrictFailsAlsoForKeptFrames) {
    options.strict = true;
    EXPECT_EQ(render(scratch / "fine", "1-6"), ExitCode::done);

    source.not_finite = {4};
    EXPECT_EQ(render(scratch / "nan", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(source.rendered, SizeIs(6));
    EXPECT_THAT(out, HasSubstr("frame 4 had 1 values that were not finite"));
    EXPECT_EQ(render(scratch / "nan", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(source.rendered, IsEmpty());
    EXPECT_EQ(render(scratch / "nan", "1-3"), ExitCode::done);

    source.not_finite = {};
    source.partly = {2};
    EXPECT_EQ(render(scratch / "partly", "1-6"), ExitCode::check_failed);
    EXPECT_THAT(out, HasSubstr("frame 2 was done partly (noise: made up)"));
    options.strict = false;
    EXPECT_EQ(render(scratch / "partly", "1-6"), ExitCode::done);
}

TEST_F(FrameLoopTest, StaleTemporariesGo) {
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::done);
    char host[256] = {};
    gethostname(host, sizeof host - 1);
    // Process numbers end at 2^22 on Linux, so none has this one.
    const std::string suffix = "." + std::string(host) + ".99999999.tmp";
    const std::vector<std::string> stale = {scratch / "out/linear/.fake.0002.exr" + suffix,
                                            scratch / "out/graded/.fake.0002.exr" + suffix,
                                            scratch / "out/.fake.mp4" + suffix};
    for (const std::string& path : stale) std::ofstream(path) << "torn";
    ASSERT_EQ(render(scratch / "out", "1"), ExitCode::done);
    for (const std::string& path : stale) EXPECT_FALSE(std::filesystem::exists(path)) << path;
}

TEST_F(FrameLoopTest, EventsAreLinesOfJson) {
    event_log = scratch / "events.jsonl";
    ASSERT_EQ(render(scratch / "out", "1-2"), ExitCode::done);
    ASSERT_EQ(render(scratch / "out", "2-3"), ExitCode::done);
    std::ifstream stream(event_log);
    std::vector<std::string> events;
    for (std::string line; std::getline(stream, line);) {
        const auto json = nlohmann::json::parse(line);
        EXPECT_EQ(json.at("v"), 1);
        EXPECT_GT(json.at("t").get<double>(), 1.6e9);
        events.push_back(json.at("event"));
        if (json.contains("frame")) events.back() += ' ' + json.at("frame").dump();
    }
    EXPECT_THAT(events,
                ElementsAre("run_started", "frame_rendered 1", "frame_rendered 2", "run_ended", "run_started",
                            "frame_kept 2", "frame_rendered 3", "clip_measured", "run_ended"));
}

TEST_F(FrameLoopTest, ProgressIsPlainLinesWhereThereIsNoTerminal) {
    ASSERT_EQ(render(scratch / "out", "1-3"), ExitCode::done);
    EXPECT_THAT(out, Not(HasSubstr("\r")));
    EXPECT_THAT(out, HasSubstr("1 of 3 done, 0:00 left\n"));
    EXPECT_THAT(out, HasSubstr("3 of 3 done\n"));
    EXPECT_EQ(format_duration(59.6), "1:00");
    EXPECT_EQ(format_duration(3723), "1:02:03");
}

TEST(OutputPaths, NamesFilesThatStayInTheFolder) {
    const OutputPaths paths("out", "clip");
    EXPECT_EQ(paths.linear(7), "out/linear/clip.0007.exr");
    EXPECT_EQ(paths.graded(12345), "out/graded/clip.12345.exr");
    EXPECT_EQ(paths.linear(-7), "out/linear/clip.-007.exr");
    EXPECT_EQ(paths.preview(), "out/clip.mp4");
    for (const char* name : {"", "../clip", "a/b", ".hidden"}) {
        EXPECT_THROW(OutputPaths("out", name), Error) << name;
    }
}

TEST(Job, HashTellsPartsApart) {
    Job a = fake_job();
    Job b = fake_job();
    EXPECT_EQ(a.hash(), b.hash());
    b.clip.last_frame = 99;
    b.provenance = {};
    EXPECT_EQ(a.hash(), b.hash());
    a.parts = {{"ab", "c"}};
    b.parts = {{"a", "bc"}};
    EXPECT_NE(a.hash(), b.hash());
    EXPECT_EQ(differences({{"timeline", "1"}, {"program", "2"}}, {{"timeline", "1"}, {"program", "3"}}),
              "the program");
    EXPECT_EQ(differences({{"timeline", "1"}}, {{"timeline", "2"}, {"device type", "cpu"}}),
              "the timeline, the device type");
}

TEST(Job, FilesAreHashedByContentAndOrder) {
    const ScratchFolder scratch;
    std::ofstream(scratch / "a") << "one";
    std::ofstream(scratch / "b") << "two";
    std::ofstream(scratch / "c") << "one";
    EXPECT_EQ(hash_files({scratch / "a", scratch / "b"}), hash_files({scratch / "c", scratch / "b"}));
    EXPECT_NE(hash_files({scratch / "a", scratch / "b"}), hash_files({scratch / "b", scratch / "a"}));
    EXPECT_THROW(hash_files({scratch / "missing"}), Error);
}

}  // namespace
}  // namespace dapple::run
