// What bench computes without rendering: ladders, overrides, times, and the time to an error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/temporary_folder.h"
#include "judge/bench_error_times.h"
#include "judge/bench_plan.h"
#include "judge/bench_process.h"
#include "judge/bench_report.h"
#include "judge/bench_timing.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kSmall = std::string(DAPPLE_SOURCE_DIR) + "/tests/end_to_end/small.yaml";
const std::string kPool = std::string(DAPPLE_SOURCE_DIR) + "/sequences/pool.yaml";

/// The message of the Error(usage) that `call` throws.
template <class Call>
std::string usage_error(const Call& call) {
    try {
        call();
    } catch (const timeline::TimelineError& error) {
        return "timeline: " + to_string(error);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage) << error.what();
        return error.what();
    }
    return "no error";
}

std::string plan_error(const PlanOptions& options) {
    return usage_error([&] { plan_bench(kSmall, options); });
}

TEST(Ladder, IsReadWithBracketsAndQuotes) {
    EXPECT_EQ(parse_ladder("sliced_beams:water.mesh_cells=100,200"),
              (Ladder{"sliced_beams", "water.mesh_cells", {"100", "200"}}));
    EXPECT_EQ(parse_ladder("a: b = 1 , [2, 3], {x: 4, y: 5}, \"6,7\""),
              (Ladder{"a", "b", {"1", "[2, 3]", "{x: 4, y: 5}", "\"6,7\""}}));
}

TEST(Ladder, FaultsAreSaid) {
    for (const char* text :
         {"", "sliced_beams", "water.mesh_cells=1", "a=b:c", "a:=1", ":b=1", "a:b=", "a:b=1,,2"})
        EXPECT_THAT(usage_error([&] { parse_ladder(text); }), HasSubstr("write METHOD:KEY=V1,V2")) << text;
    EXPECT_THAT(usage_error([] { parse_ladder("a:caustics.method=b"); }), HasSubstr("one method's key"));
}

TEST(Plan, HasEveryMethodOverItsDefaultLadder) {
    const BenchPlan plan = plan_bench(kPool, {});
    ASSERT_EQ(plan.ladders.size(), judged_methods().size());
    EXPECT_THAT(judged_methods(), testing::Not(Contains("reference")));
    EXPECT_EQ(plan.ladders[0].name(), "sliced_beams, water.mesh_cells");
    EXPECT_EQ(plan.ladders[1].values, (std::vector<std::string>{"256", "512", "1024", "2048"}));
    EXPECT_EQ(plan.ladders[2], (Ladder{"adaptive_beams", "caustics.levels", {"0", "1", "2", "3", "4", "5"}}));
    // 25 cells a wave of 0.306 m over 8 m come to 654; about that, by factors of two.
    ASSERT_EQ(plan.ladders[0].values.size(), 4u);
    const double middle = std::stod(plan.ladders[0].values[2]);
    EXPECT_NEAR(middle, 8 / 0.306 * 25, 20);
    EXPECT_NEAR(std::stod(plan.ladders[0].values[3]), 2 * middle, 1);
    for (const Rung& rung : plan.rungs) EXPECT_EQ(rung.name.find('/'), std::string::npos);
}

TEST(Plan, RefusesWhatCannotBe) {
    EXPECT_THAT(plan_error({.methods = {"sliced_beam"}}), HasSubstr("did you mean 'sliced_beams'?"));
    EXPECT_THAT(plan_error({.methods = {"reference"}}), HasSubstr("cannot be judged itself"));
    EXPECT_THAT(plan_error({.methods = {"sliced_beams", "sliced_beams"}}), HasSubstr("twice"));
    EXPECT_THAT(plan_error({.methods = {"sliced_beams"}, .ladders = {"photon_splatting:water.mesh_cells=8"}}),
                HasSubstr("--methods leaves out"));
    EXPECT_THAT(plan_error({.ladders = {"sliced_beams:water.mesh_cells=8,8"}}), HasSubstr("two rungs"));
    EXPECT_THAT(plan_error({.settings = {"caustics.method=reference"}}), HasSubstr("--methods"));
    EXPECT_THAT(plan_error({.settings = {"caustics.map_resolutin=8"}}),
                HasSubstr("did you mean 'map_resolution'?"));
    // What only the timeline can tell.
    EXPECT_THAT(plan_error({.ladders = {"sliced_beams:water.mesh_cels=8"}}),
                HasSubstr("did you mean 'mesh_cells'?"));
    EXPECT_THAT(plan_error({.ladders = {"sliced_beams:caustics.map_resolution=8"}}), HasSubstr("timeline:"));
    EXPECT_THAT(plan_error({.ladders = {"sliced_beams:water.mesh_cells=many"}}), HasSubstr("timeline:"));
}

TEST(Plan, GivesKeysToTheMethodsThatKnowThem) {
    // small.yaml's own method is photon_splatting, with a map_resolution of 128.
    const BenchPlan plan = plan_bench(
        kSmall, {.ladders = {"photon_splatting:water.mesh_cells=32"},
                 .settings = {"clip.samples=1", "caustics.sun_samples=3", "caustics.map_resolution=64"},
                 .reference_error = 0.25});
    for (const Rung& rung : plan.rungs) {
        const auto state = timeline::Timeline::load(kSmall, rung.overrides).at(1);
        EXPECT_EQ(state.clip.samples, 1);
        EXPECT_EQ(state.caustics.method, plan.ladders[rung.ladder].method);
        const bool beams = state.caustics.method == "sliced_beams";
        EXPECT_EQ(state.caustics.sliced_beams.sun_samples, beams ? 3 : 1);
        if (state.caustics.method == "photon_splatting") {
            EXPECT_EQ(state.caustics.map.map_resolution, 64);
        }
    }
    const auto reference = timeline::Timeline::load(kSmall, plan.reference_overrides).at(1);
    EXPECT_EQ(reference.caustics.method, "reference");
    EXPECT_EQ(reference.caustics.reference.standard_error, 0.25);
    // A setting of the user's own counts more than the default.
    const BenchPlan own = plan_bench(kSmall, {.settings = {"caustics.standard_error=0.5"}});
    EXPECT_EQ(
        timeline::Timeline::load(kSmall, own.reference_overrides).at(1).caustics.reference.standard_error,
        0.5);
}

TEST(Spread, IsThatOfFramesAboutTheirMedians) {
    // Frames of 1 and 4 s; the second repeat is 10 % slower in the first frame, the third 5 % faster in both.
    const Spread spread = spread_of({{1.0, 4.0}, {1.1, 4.0}, {0.95, 3.8}});
    EXPECT_DOUBLE_EQ(spread.median, 2.5);
    EXPECT_DOUBLE_EQ(spread.least, 0.95 * 2.5);
    EXPECT_DOUBLE_EQ(spread.most, 1.1 * 2.5);
    const Spread even = spread_of({{1.0}, {3.0}});
    EXPECT_DOUBLE_EQ(even.median, 2);
    EXPECT_DOUBLE_EQ(even.least, 1);
    EXPECT_DOUBLE_EQ(even.most, 3);
}

TEST(TimeToError, InterpolatesAPowerLaw) {
    // error = 0.16 / t^2: the time to an error is 0.4 / sqrt(error), whatever the rungs.
    std::vector<std::pair<double, double>> points;
    for (const double t : {1.0, 2.0, 4.0, 8.0}) points.emplace_back(t, 0.16 / (t * t));
    for (const double error : {0.05, 0.02, 0.01}) {
        const TimeToError time = time_to_error(points, error);
        EXPECT_EQ(time.state, TimeToError::State::reached);
        EXPECT_NEAR(time.seconds, 0.4 / std::sqrt(error), 1e-12) << error;
    }
    EXPECT_EQ(time_to_error(points, 0.001).state, TimeToError::State::not_reached);
    const TimeToError first = time_to_error(points, 0.2);
    EXPECT_EQ(first.state, TimeToError::State::at_most);
    EXPECT_EQ(first.seconds, 1);
    EXPECT_EQ(to_string(first), "<= 1.000 s");
    EXPECT_EQ(to_string(time_to_error(points, 0.001)), "not reached");
}

TEST(TimeToError, TakesTheFirstCrossingAndAnyOrder) {
    // Not monotone: down to 1 % at 4 s, up again, down again.
    const TimeToError time = time_to_error({{16, 0.005}, {4, 0.01}, {1, 0.04}, {8, 0.03}}, 0.02);
    EXPECT_EQ(time.state, TimeToError::State::reached);
    EXPECT_NEAR(time.seconds, 2, 1e-12);
    EXPECT_EQ(time_to_error({}, 0.1).state, TimeToError::State::not_reached);
    EXPECT_EQ(time_to_error({{1, std::nan("")}}, 0.1).state, TimeToError::State::not_reached);
}

TEST(TimeToError, AnErrorTooSmallToBeToldIsReachedAtMostThen) {
    // An error of 0 has no logarithm, so that nothing can be interpolated on the way to it.
    for (const auto& points : {std::vector<std::pair<double, double>>{{1, 0}, {2, 0.5}},
                               {{0.5, 0.3}, {1, 0}},
                               {{0.5, std::numeric_limits<double>::infinity()}, {1, 0.05}}}) {
        const TimeToError time = time_to_error(points, 0.1);
        EXPECT_EQ(time.state, TimeToError::State::at_most);
        EXPECT_EQ(time.seconds, 1);
        EXPECT_EQ(to_string(time), "<= 1.000 s");
    }
    // A larger error is between the rungs.
    EXPECT_EQ(time_to_error({{0.5, 0.3}, {1, 0.1}, {2, 0}}, 0.2).state, TimeToError::State::reached);
}

constexpr const char* kStats =
    R"({"frame":1,"wall_s":2.0,"cpu_s":3.0,"passes":[{"name":"light","wall_s":1.5,"cpu_s":2.5,"device_s":0},{"name":"write","wall_s":0.5,"cpu_s":0.5,"device_s":0}],"counts":{"lost to x, W":0.25},"peak_memory":1024,"non_finite":0,"linear":{"bytes":1,"hash":"a"},"graded":{"bytes":1,"hash":"b"}}
{"summary":{"anything":1}}
{"frame":2,"wall_s":9.0,"cpu_s":9.0,"passes":[],"counts":{},"peak_memory":2048,"non_finite":2,"linear":{"bytes":1,"hash":"w"},"graded":{"bytes":1,"hash":"b"}}
{"frame":3,"wall_s":
)";

TEST(Repeat, IsReadFromStatsAndKeptAsJson) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "stats.jsonl") << kStats;
    EXPECT_FALSE(read_repeat(folder / "stats.jsonl", 2, {1, 3}));
    std::optional<Repeat> repeat = read_repeat(folder / "stats.jsonl", 2, {1});
    ASSERT_TRUE(repeat);
    repeat->process_wall_s = 12;
    EXPECT_EQ(repeat->frames.at(1).counts.at("lost to x, W"), 0.25);

    const auto again = repeats_from_json(to_json(std::vector<Repeat>{*repeat, *repeat}));
    ASSERT_TRUE(again);
    ASSERT_EQ(again->size(), 2u);
    const Timing timing = timing_of(*again);
    EXPECT_DOUBLE_EQ(timing.wall_s.median, 1.5) << "without writing";
    EXPECT_DOUBLE_EQ(timing.cpu_s.median, 2.5);
    EXPECT_DOUBLE_EQ(timing.warm_up_s, 9 - 1.5);
    EXPECT_DOUBLE_EQ(timing.start_up_s, 12 - 9 - 2);
    EXPECT_TRUE(timing.same_bits);
    ASSERT_EQ(timing.passes.size(), 2u);
    EXPECT_EQ(timing.passes[1].name, "write");

    Repeat other = *repeat;
    other.frames.at(1).content = "c";
    EXPECT_FALSE(timing_of({*repeat, other}).same_bits);
    EXPECT_FALSE(repeats_from_json("[{}]"));
    EXPECT_FALSE(repeats_from_json("nonsense"));
}

TEST(Process, TellsHowItEnded) {
    const auto never = [] { return false; };
    std::vector<std::string> lines;
    const auto keep = [&](const std::string& line) { lines.push_back(line); };
    EXPECT_TRUE(run_process({"/bin/sh", "-c", "echo one; echo two >&2"}, never, keep).done());
    EXPECT_THAT(lines, ElementsAre("one", "two"));
    const ProcessEnd failed =
        run_process({"/bin/sh", "-c", "echo 'ERROR [33] too large'; exit 33"}, never, keep);
    EXPECT_EQ(failed.exit_code, 33);
    EXPECT_EQ(failed.error, "too large");
    const ProcessEnd killed = run_process({"/bin/sh", "-c", "kill -SEGV $$"}, never, keep);
    EXPECT_EQ(killed.signal, SIGSEGV);
    EXPECT_FALSE(killed.done());
    EXPECT_THAT(killed.error, HasSubstr("ended by signal"));
    EXPECT_THAT(run_process({"/no/such/program"}, never, keep).error, HasSubstr("cannot be started"));
    // Asked to stop, once.
    const ProcessEnd stopped = run_process(
        {"/bin/sh", "-c", "trap 'exit 75' TERM; while :; do sleep 0.05; done"}, [] { return true; }, keep);
    EXPECT_TRUE(stopped.exit_code == 75 || stopped.signal == SIGTERM);
}

/// A result of one ladder, with names that a page must not take for tags.
BenchResult made_up_result() {
    BenchResult result;
    result.timeline = "a <b> & \"c\".yaml";
    result.frames = "1-3";
    result.layer = "E";
    result.width = result.height = 2;
    result.ladders = {{"sliced_beams", "water.mesh_cells", {"10", "20"}}};
    ReferenceResult reference;
    reference.noise = {1, 400, 0.01, 0.008};
    reference.wall_s = 10;
    reference.cpu_s = 20;
    result.reference = reference;
    for (const double t : {1.0, 2.0}) {
        RungResult rung;
        rung.rung = {0, t == 1 ? "10" : "20", "sliced_beams-" + std::to_string(t), {}};
        rung.timing.wall_s = rung.timing.cpu_s = {t, t, t};
        rung.repeats = 3;
        rung.judged.errors.l1_inside = rung.judged.errors.rmse_less_noise = 0.08 / (t * t);
        rung.judged.map = {2, 2, 2, {0, 0.1f, 0.2f, std::nanf("")}};
        result.rungs.push_back(rung);
    }
    RungResult failed;
    failed.rung = {0, "30", "sliced_beams-30", {}};
    failed.failure = "exit 33: more memory";
    result.rungs.push_back(failed);
    result.hard_cases = {
        {"case",
         "what <it> is",
         "dark",
         {{"sliced_beams", Verdict::fails, "2 values"}, {"reference", Verdict::named, "the plan says it"}}},
        {"other", "", "dark", {{"sliced_beams", Verdict::holds, "light right"}}}};
    result.hard_cases[1].verdicts[0].scattered =
        ScatteredVerdict{Verdict::fails, "S <too> dark", -0.03, 0.03};
    result.provenance = {{"command", "dapple bench"}};
    return result;
}

TEST(Report, HoldsAllFigures) {
    const BenchResult result = made_up_result();
    const std::string html = bench_html(result);
    for (const char* text : {"a &lt;b&gt; &amp;", "what &lt;it&gt; is", "exit 33: more memory", "<svg",
                             "1.265 s", "not reached", "id=\"data\"", "fails"})
        EXPECT_THAT(html, HasSubstr(text));
    EXPECT_THAT(bench_text(result), HasSubstr("1.265 s"));
    const std::string json = bench_json(result);
    EXPECT_THAT(json, HasSubstr("\"not_reached\""));
    EXPECT_EQ(case_failures(result),
              (std::vector<std::string>{"case, sliced_beams fails: 2 values",
                                        "other, sliced_beams fails in S: S <too> dark"}));
    EXPECT_THAT(html, HasSubstr("S &lt;too&gt; dark"));
    EXPECT_THAT(json, HasSubstr("\"S <too> dark\""));
    EXPECT_THAT(bench_text(result), HasSubstr("case, sliced_beams fails: 2 values"));
    EXPECT_THAT(bench_text(result),
                HasSubstr("2 hard cases, 4 verdicts: 1 hold, 1 differ as the plan says, 2 fail"));
    // As many fields in every line of the table, whatever the run.
    const std::string csv = bench_csv(result);
    std::vector<long> commas;
    std::string line;
    for (const char c : csv) {
        if (c != '\n') {
            line += c;
            continue;
        }
        commas.push_back(std::count(line.begin(), line.end(), ','));
        line.clear();
    }
    EXPECT_THAT(commas, ElementsAre(commas.at(0), commas.at(0), commas.at(0), commas.at(0)));
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t times = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++times;
    return times;
}

/// The same of a timeline that scatters light; the second rung's method has none of it.
BenchResult made_up_scattering() {
    BenchResult result = made_up_result();
    result.reference->scattered = ReferenceNoise{2, 400, 0.03, 0.024};
    ClipErrors& errors = result.rungs[0].scattered.emplace();
    errors.l1 = 0.0123;
    errors.rmse_less_noise = 0.0345;
    return result;
}

TEST(Report, DrawsTheReferencesOwnErrorOverTime) {
    BenchResult result = made_up_result();
    const TimesAndErrors points = reference_times_and_errors(result, Judged::layer, Clock::cpu, kL1Inside);
    ASSERT_EQ(points.size(), 5u) << "four times the time halves it; a thousandth of the time is the least";
    EXPECT_EQ(points.back(), std::make_pair(20.0, 0.008));
    EXPECT_EQ(points.front(), std::make_pair(20.0 / 256, 16 * 0.008));
    EXPECT_THAT(bench_html(result), HasSubstr("reference, its noise"));
    // 0.8 % (L1) and 1 % (RMSE) in 10 s: 1 % took 6.4 and 10 s, 5 % 0.256 and 0.4 s.
    for (const char* row : {"0.256 s", "1.600 s", "6.400 s", "0.400 s", "2.500 s", "10.000 s"})
        EXPECT_THAT(times_to_errors(result)[2], Contains(row));
    const auto times = nlohmann::json::parse(bench_json(result)).at("reference").at("time_to_error");
    EXPECT_NEAR(times[2].at("cpu").at("l1_inside").at("seconds"), 12.8, 1e-12);
    // Of layers without a variance nothing is known.
    result.reference->noise = {1, 400, {}, {}};
    EXPECT_TRUE(reference_times_and_errors(result, Judged::layer, Clock::wall, kL1Inside).empty());
    EXPECT_THAT(times_to_errors(result)[2], Contains("not known").Times(6));
    EXPECT_THAT(bench_json(result), HasSubstr("\"not_known\""));
    EXPECT_THAT(bench_html(result), testing::Not(HasSubstr("reference, its noise")));
}

TEST(Report, TellsErrorsOfScatteredLightWhereThereIsAny) {
    const std::string clear = bench_html(made_up_result());
    EXPECT_THAT(clear, testing::Not(HasSubstr("Scattered light")));
    EXPECT_THAT(bench_text(made_up_result()), testing::Not(HasSubstr("S: L1")));
    const BenchResult result = made_up_scattering();
    const std::string html = bench_html(result);
    for (const char* text : {"Scattered light", "Relative L1 of scattered light", "S: L1 5 %", "none"})
        EXPECT_THAT(html, HasSubstr(text));
    EXPECT_EQ(count(html, "<svg"), count(clear, "<svg") + 2);
    EXPECT_THAT(bench_text(result), HasSubstr("scattered light: noise 3"));
    const auto json = nlohmann::json::parse(bench_json(result));
    EXPECT_EQ(json.at("runs")[0].at("scattered").at("l1"), 0.0123);
    EXPECT_TRUE(json.at("runs")[1].at("scattered").is_null());
    EXPECT_EQ(json.at("reference").at("scattered").at("noise_rmse"), 0.03);
    // 1.23 % in a second, by its only rung.
    const auto& times = json.at("ladders")[0].at("time_to_error");
    EXPECT_EQ(times[1].at("wall").at("scattered_l1").at("state"), "at_most");
    EXPECT_EQ(times[2].at("wall").at("scattered_l1").at("state"), "not_reached");
    EXPECT_FALSE(nlohmann::json::parse(bench_json(made_up_result())).at("reference").contains("scattered"));
    const std::string csv = bench_csv(result);
    EXPECT_THAT(csv, HasSubstr(",0.0123,"));
    EXPECT_EQ(count(csv, ","), count(bench_csv(made_up_result()), ","));
}

TEST(Report, EveryRowHasAsManyCellsAsItsHead) {
    const std::string html = bench_html(made_up_scattering());
    std::size_t tables = 0, rows = 0;
    for (std::size_t at = html.find("<table"); at != std::string::npos; at = html.find("<table", at + 1)) {
        const std::string table = html.substr(at, html.find("</table>", at) - at);
        const std::size_t columns = count(table, "<th ");
        for (std::size_t row = table.find("<tr><td"); row != std::string::npos;
             row = table.find("<tr><td", row + 1)) {
            EXPECT_EQ(count(table.substr(row, table.find("</tr>", row) - row), "<td"), columns)
                << table.substr(row, 200);
            ++rows;
        }
        ++tables;
    }
    EXPECT_EQ(tables, 7u);
    EXPECT_GT(rows, 8u);
}

TEST(Report, ErrorsTooSmallToBeToldAreDrawnAndSaid) {
    BenchResult result = made_up_result();
    result.rungs[1].judged.errors.rmse_less_noise = 0;
    EXPECT_THAT(bench_html(made_up_result()), testing::Not(HasSubstr("too small to be told")));
    EXPECT_THAT(bench_html(result), HasSubstr("too small to be told from the reference&#39;s noise, drawn at "
                                              "0.01: sliced_beams, water.mesh_cells at 2.000 s."));
    EXPECT_THAT(bench_text(result), HasSubstr("<= 2.000 s"));
}

TEST(Report, InfinityIsToldFromNoFigure) {
    BenchResult result = made_up_result();
    ClipErrors& errors = result.rungs[0].judged.errors;
    errors.energy = errors.l1_inside = std::numeric_limits<double>::infinity();
    result.hard_cases[0].verdicts[0].energy = std::numeric_limits<double>::infinity();
    const auto json = nlohmann::json::parse(bench_json(result));
    EXPECT_EQ(json.at("runs")[0].at("errors").at("energy"), "inf");
    EXPECT_EQ(json.at("runs")[0].at("errors").at("l1_inside"), "inf");
    EXPECT_TRUE(json.at("runs")[0].at("errors").at("flicker").is_null());
    EXPECT_EQ(json.at("hard_cases")[0].at("verdicts")[0].at("energy"), "inf");
}

}  // namespace
}  // namespace dapple::judge
