// The verb bench, on a small timeline.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "end_to_end/program.h"

namespace dapple::end_to_end {
namespace {

using testing::HasSubstr;
using testing::SizeIs;
using testing_tools::ChildProcess;
using testing_tools::file_text;
using testing_tools::Outcome;
using testing_tools::ScratchFolder;
using Json = nlohmann::json;

/// A picture of 32 x 18 of small.yaml, by few beams and photons, and a coarse reference.
std::vector<std::string> small_bench(const std::string& folder, int repeats) {
    return {"bench",
            kSmall,
            "-o",
            folder,
            "--set",
            "clip.resolution=[32, 18]",
            "--set",
            "clip.samples=1",
            "--methods",
            "sliced_beams,photon_splatting",
            "--ladder",
            "sliced_beams:water.mesh_cells=16,48",
            "--ladder",
            "photon_splatting:caustics.map_resolution=64",
            "-f",
            "3",
            "--repeats",
            std::to_string(repeats),
            "--reference-error",
            "0.2"};
}

Json report_of(const std::string& folder) {
    return Json::parse(file_text(folder + "/bench.json"));
}

/// All errors by run.
Json errors_of(const Json& report) {
    Json errors;
    for (const Json& run : report.at("runs")) errors[run.at("name").get<std::string>()] = run.at("errors");
    return errors;
}

TEST(Bench, TwiceFindsTheSameErrors) {
    const ScratchFolder scratch;
    const Outcome first = run_dapple(scratch, small_bench(scratch / "a", 2));
    ASSERT_EQ(first.code, 0) << first.output;
    EXPECT_THAT(first.output, HasSubstr("photon_splatting-caustics.map_resolution=64"));
    const Json report = report_of(scratch / "a");
    ASSERT_THAT(report.at("runs"), SizeIs(3));
    for (const Json& run : report.at("runs")) {
        EXPECT_EQ(run.at("same_bits"), true);
        EXPECT_EQ(run.at("repeats"), 2);
        EXPECT_EQ(run.at("non_finite"), 0);
        EXPECT_GT(run.at("timing").at("wall_s").at("median"), 0);
        EXPECT_GT(run.at("timing").at("peak_memory"), 50 << 20);
        EXPECT_GT(run.at("timing").at("passes").size(), 5u);
        EXPECT_TRUE(run.at("errors").at("flicker").is_null()) << "one frame has no flicker";
        EXPECT_GT(run.at("errors").at("compared"), 0.5);
    }
    const Json errors = errors_of(report);
    const auto rmse = [&](const char* name) { return errors.at(name).at("rmse_less_noise").get<double>(); };
    EXPECT_GT(rmse("sliced_beams-water.mesh_cells=16"), 2 * rmse("sliced_beams-water.mesh_cells=48"));
    const std::string html = file_text(scratch / "a/index.html");
    EXPECT_THAT(html, HasSubstr("Error over time"));
    EXPECT_THAT(html, HasSubstr("</html>"));

    const Outcome second = run_dapple(scratch, small_bench(scratch / "b", 1));
    ASSERT_EQ(second.code, 0) << second.output;
    EXPECT_EQ(errors_of(report_of(scratch / "b")), errors);

    // Again into the same folder: nothing is rendered, and the report is the same.
    const Outcome again = run_dapple(scratch, small_bench(scratch / "a", 2));
    ASSERT_EQ(again.code, 0) << again.output;
    EXPECT_THAT(again.output, HasSubstr("2 repeats kept"));
    EXPECT_EQ(report_of(scratch / "a").at("runs"), report.at("runs"));

    EXPECT_FALSE(report.at("reference").contains("scattered")) << "the water is clear";

    // Another job: times of the old one are not trusted. One rung, and a reference as coarse as can be, of
    // water that scatters light.
    const Outcome anew = run_dapple(scratch, {"bench",
                                              kSmall,
                                              "-o",
                                              scratch / "a",
                                              "--set",
                                              "clip.resolution=[32, 18]",
                                              "--set",
                                              "clip.samples=1",
                                              "--set",
                                              "water.scattering=[0.1, 0.1, 0.1]",
                                              "--ladder",
                                              "sliced_beams:water.mesh_cells=16",
                                              "--methods",
                                              "sliced_beams",
                                              "-f",
                                              "3",
                                              "--repeats",
                                              "1",
                                              "--reference-error",
                                              "1"});
    ASSERT_EQ(anew.code, 0) << anew.output;
    EXPECT_EQ(anew.output.find("repeats kept"), std::string::npos) << anew.output;
    const Json murky = report_of(scratch / "a");
    EXPECT_GT(murky.at("reference").at("scattered").at("mean"), 0);
    EXPECT_GT(murky.at("reference").at("scattered").at("noise_rmse"), 0);
    // 16 cells over 4 m and a reference that may be off by its own size: about right is all that can be told.
    EXPECT_GT(murky.at("runs")[0].at("scattered").at("l1"), 0);
    EXPECT_LT(std::abs(murky.at("runs")[0].at("scattered").at("bias").get<double>()), 0.5);
    EXPECT_THAT(file_text(scratch / "a/index.html"), HasSubstr("Relative L1 of scattered light"));
}

TEST(Bench, GoesOnAfterAnInterruption) {
    const ScratchFolder scratch;
    ChildProcess child(dapple(small_bench(scratch / "out", 2)), scratch / "output.txt");
    // After the first run has its times.
    const std::string timings = scratch / "out/runs/sliced_beams-water.mesh_cells=16/timings.json";
    for (int i = 0; i < 1200 && !std::filesystem::exists(timings); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    child.signal(SIGINT);
    ASSERT_EQ(child.wait(), 75) << child.output();
    EXPECT_THAT(child.output(), HasSubstr("interrupted; the same command goes on"));
    EXPECT_FALSE(std::filesystem::exists(scratch / "out/bench.json"));
    // One repeat is enough now: that of the first run is kept.
    const Outcome rest = run_dapple(scratch, small_bench(scratch / "out", 1));
    ASSERT_EQ(rest.code, 0) << rest.output;
    EXPECT_THAT(rest.output, HasSubstr("repeats kept"));
    EXPECT_THAT(report_of(scratch / "out").at("runs"), SizeIs(3));
}

TEST(Bench, GivesAVerdictOnEveryHardCase) {
    const ScratchFolder scratch;
    std::filesystem::create_directory(scratch / "cases");
    const auto add_case = [&](const std::string& name, const std::string& change, const std::string& to) {
        std::string text = file_text(kFolder + "/probe.yaml");
        const std::size_t at = text.find(change);
        ASSERT_NE(at, std::string::npos);
        text.replace(at, change.size(), to);
        std::ofstream(scratch / "cases/" + name) << text;
    };
    add_case("dot.yaml", "frames: 1-4, resolution: [64, 36]", "frames: 1, resolution: [16, 9]");
    add_case("set_sun.yaml", "elevation: 90 deg", "direction: [1, 0.1, 0]");
    std::ofstream(scratch / "cases/dot.yaml", std::ios::app)
        << "caustics: {method: photon_splatting, map_resolution: 300}\n";
    const Outcome outcome =
        run_dapple(scratch, {"bench", "--hard-cases", scratch / "cases", "-o", scratch / "out"});
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const Json cases = report_of(scratch / "out").at("hard_cases");
    ASSERT_THAT(cases, SizeIs(2));
    for (const Json& hard : cases) {
        ASSERT_THAT(hard.at("verdicts"), SizeIs(4)) << "a method each, but for the reference";
        for (const Json& verdict : hard.at("verdicts")) EXPECT_EQ(verdict.at("verdict"), "holds") << verdict;
    }
    EXPECT_THAT(file_text(scratch / "out/hard_cases/dot/photon_splatting/stats.jsonl"),
                HasSubstr("\"photons\":90000.0"))
        << "with the key that the timeline sets for its own method";
    EXPECT_EQ(cases[0].at("verdicts")[0].at("exit_code"), 0);
    EXPECT_EQ(cases[1].at("verdicts")[0].at("exit_code"), 3);
    EXPECT_THAT(cases[1].at("verdicts")[0].at("reason").get<std::string>(), HasSubstr("refused by all"));
}

TEST(Bench, WrongCallsAreRefused) {
    const ScratchFolder scratch;
    const auto expect = [&](std::vector<std::string> arguments, int code, const std::string& text) {
        arguments.insert(arguments.begin(), "bench");
        arguments.insert(arguments.end(), {"-o", scratch / "out"});
        const Outcome outcome = run_dapple(scratch, arguments);
        EXPECT_EQ(outcome.code, code) << outcome.output;
        EXPECT_THAT(outcome.output, HasSubstr(text));
        EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
    };
    expect({}, 2, "--hard-cases FOLDER");
    expect({kSmall, "--methods", "sliced"}, 2, "there is no method 'sliced'");
    expect({kSmall, "--ladder", "sliced_beams"}, 2, "METHOD:KEY=V1,V2");
    expect({kSmall, "--repeats", "0"}, 2, "--repeats");
    expect({kSmall, "-f", "1:3"}, 2, "write 1-10x2");
    expect({"--hard-cases", scratch / "none"}, 2, "no folder of timelines");
    expect({"--hard-cases", kFolder, "--set", "clip.samples=1"}, 2, "hard cases are rendered as they are");
    expect({"--hard-cases", kFolder, "--methods", "sliced"}, 2, "there is no method 'sliced'");
    expect({kSmall, "--ladder", "sliced_beams:water.mesh_cels=3"}, 3, "did you mean 'mesh_cells'?");
    expect({scratch / "none.yaml"}, 4, "none.yaml");
    expect({kSmall, "--device", "no such device"}, 7, "no such device");
}

}  // namespace
}  // namespace dapple::end_to_end
