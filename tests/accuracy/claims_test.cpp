// The claims of papers in sequences/claims: each row's figure is what is recorded there, or the row says that
// it changed. DAPPLE_LONG: all of them; else those that render in seconds, and what a changed row ends with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "run/child_process.h"
#include "run/scratch_folder.h"
#include "source_dir.h"

namespace dapple {
namespace {

using testing_tools::Outcome;
using testing_tools::ScratchFolder;

const std::string kClaims = std::string(DAPPLE_SOURCE_DIR) + "/sequences/claims";

Outcome bench(const ScratchFolder& scratch, const std::string& claims) {
    return testing_tools::run_program(
        {DAPPLE_PROGRAM, "bench", "--claims", claims, "--repeats", "1", "-o", scratch / "out"},
        scratch / "output.txt");
}

class Claims : public testing::TestWithParam<std::string> {};

TEST_P(Claims, AreAsRecorded) {
    const ScratchFolder scratch;
    const Outcome outcome = bench(scratch, kClaims + "/" + GetParam() + ".yaml");
    printf("%s\n", outcome.output.c_str());
    EXPECT_EQ(outcome.code, 0);
    const auto report = nlohmann::json::parse(testing_tools::file_text(scratch / "out/bench.json"));
    for (const auto& row : report.at("claims").at(0).at("rows")) {
        const std::string state = row.at("state").get<std::string>();
        EXPECT_TRUE(state == "as recorded" || state == "reported") << row;
    }
}

#if DAPPLE_LONG
std::vector<std::string> names() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(kClaims))
        if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    return names;
}
#else
std::vector<std::string> names() {
    return {"cascade_seams", "leakage"};
}

TEST(ClaimsOfItsOwn, AChangedRowFailsAndBadInputIsRefused) {
    const ScratchFolder scratch;
    const auto write = [&](const std::string& name, const std::string& most) {
        std::ofstream(scratch / name)
            << "dapple_claim: 1\nsource: this test\nclaim: more photons, less error\n"
               "timeline: "
            << DAPPLE_SOURCE_DIR
            << "/tests/end_to_end/small.yaml\n"
               "frames: 3\n"
               "settings: {clip.resolution: [32, 18], clip.samples: 1}\n"
               "reference: {caustics: {method: sliced_beams, path_counts: false}}\n"
               "runs:\n"
               "  few: {caustics: {method: photon_splatting, map_resolution: 16}}\n"
               "  many: {caustics: {method: photon_splatting, map_resolution: 64}}\n"
               "rows:\n"
               "  - {says: error, figure: l1, of: many, over: few, claimed: {at_most: 1}, "
               "expected: [0, "
            << most
            << "], because: photons lie closer}\n"
               "  - {says: photons, figure: count, count: photons, of: many, over: few, "
               "expected: [15, 17], because: four times as many each way}\n"
               "  - {says: time, figure: cpu, passes: splatting, of: many}\n";
    };
    write("changed.yaml", "0.0001");
    const Outcome changed = bench(scratch, scratch / "changed.yaml");
    EXPECT_EQ(changed.code, 6) << changed.output;
    EXPECT_THAT(changed.output, testing::HasSubstr("changed: error: CHANGED"));
    EXPECT_THAT(changed.output, testing::HasSubstr("holds by"));
    EXPECT_THAT(changed.output, testing::HasSubstr("reported"));
    // Again: what is finished stays, and the figures are the same.
    write("changed.yaml", "1");
    const Outcome again = bench(scratch, scratch / "changed.yaml");
    EXPECT_EQ(again.code, 0) << again.output;
    EXPECT_THAT(testing_tools::file_text(scratch / "out/index.html"),
                testing::HasSubstr("more photons, less error"));
    EXPECT_THAT(testing_tools::file_text(scratch / "out/bench.csv"),
                testing::HasSubstr("\"photons\",\"count photons\""));

    write("wrong.yaml", "high");
    const Outcome wrong = bench(scratch, scratch / "wrong.yaml");
    EXPECT_EQ(wrong.code, 3) << wrong.output;
    EXPECT_THAT(wrong.output, testing::HasSubstr("rows[0].expected"));
    EXPECT_EQ(bench(scratch, scratch / "none.yaml").code, 4);
    const Outcome both = testing_tools::run_program(
        {DAPPLE_PROGRAM, "bench", kClaims + "/timelines/leakage.yaml", "--claims", kClaims},
        scratch / "output.txt");
    EXPECT_EQ(both.code, 2) << both.output;
    EXPECT_THAT(both.output, testing::HasSubstr("name their own timelines"));
}
#endif

INSTANTIATE_TEST_SUITE_P(OfPapers, Claims, testing::ValuesIn(names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace dapple
