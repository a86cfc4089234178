// Claims of papers as files, and what is told of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "image/temporary_folder.h"
#include "judge/bench_claim_report.h"
#include "judge/bench_claims.h"
#include "judge/bench_report.h"
#include "source_dir.h"
#include "timeline/timeline.h"

namespace dapple::judge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr const char* kClaim = R"(dapple_claim: 1
source: A paper, figure 1
claim: Wide ones are as good as narrow ones.
timeline: ../sea.yaml
frames: 5,1-3
settings: {clip.resolution: [32, 18], caustics: {method: photon_splatting, denoise: {filter: fixed}}}
reference: {caustics: {method: sliced_beams}}
runs:
  wide: {caustics.inner_size: 7.5 m, output.look: 'a "b"'}
  narrow: {}
regions:
  near: {nearer_than: 750 cm}
  far: {farther_than: 15 m, box: [0, 0.5, 1, 1]}
rows:
  - {says: first, figure: l1, region: near, of: wide, over: narrow, claimed: {at_most: 1}, expected: [0.9, 1], because: so}
  - {says: second, figure: l1, of: wide, over: [reference, narrow against wide], expected: [0, 2], because: so}
  - {says: third, figure: cpu, passes: [splatting, denoise], of: wide, over: narrow, claimed: {at_least: 0.5, at_most: 0.6}}
  - {says: fourth, figure: count, count: photons, of: wide, expected: [3, 3], because: so}
)";

class ClaimFile : public testing::Test {
protected:
    Claim read(const std::string& text) {
        std::ofstream(folder_ / "claim.yaml") << text;
        return read_claim(folder_ / "claim.yaml");
    }
    /// What is said of the file above with `from` replaced.
    std::string fault(const std::string& from, const std::string& to) {
        std::string text = kClaim;
        const std::size_t at = text.find(from);
        if (at == std::string::npos) return "the text has no " + from;
        text.replace(at, from.size(), to);
        try {
            read(text);
        } catch (const timeline::TimelineError& error) {
            return to_string(error);
        }
        return "no fault";
    }

    test::TemporaryFolder folder_;
};

TEST_F(ClaimFile, HoldsRunsRegionsAndRows) {
    const Claim claim = read(kClaim);
    EXPECT_EQ(claim.name, "claim");
    EXPECT_THAT(claim.frames, ElementsAre(1, 2, 3, 5));
    EXPECT_EQ(std::filesystem::path(claim.timeline).filename(), "sea.yaml");
    const std::string size = "clip.resolution=[32, 18]",
                      splats = "caustics={method: photon_splatting, denoise: {filter: fixed}}";
    ASSERT_EQ(claim.runs.size(), 2u);
    EXPECT_THAT(claim.runs[0].overrides,
                ElementsAre(size, splats, "caustics.inner_size=7.5 m", R"(output.look="a \"b\"")"));
    EXPECT_THAT(claim.runs[1].overrides, ElementsAre(size, splats));
    ASSERT_TRUE(claim.reference);
    EXPECT_THAT(claim.reference->overrides, ElementsAre(size, splats, "caustics={method: sliced_beams}"));
    ASSERT_EQ(claim.regions.size(), 2u);
    EXPECT_DOUBLE_EQ(claim.regions[0].farthest, 7.5);
    EXPECT_EQ(claim.regions[1].farthest, kInfinity);
    EXPECT_THAT(claim.regions[1].box, ElementsAre(0, 0.5, 1, 1));
    ASSERT_EQ(claim.rows.size(), 4u);
    EXPECT_EQ(claim.rows[0].figure->name, "l1");
    EXPECT_EQ(claim.rows[0].at_most, 1.0);
    EXPECT_FALSE(claim.rows[0].at_least);
    ASSERT_EQ(claim.rows[1].over.size(), 2u);
    EXPECT_EQ(claim.rows[1].over[0].run, "reference");
    EXPECT_EQ(claim.rows[1].over[1].run, "narrow");
    EXPECT_EQ(claim.rows[1].over[1].against, "wide");
    EXPECT_THAT(claim.rows[2].passes, ElementsAre("splatting", "denoise"));
    EXPECT_FALSE(claim.rows[2].expected);
    EXPECT_EQ(claim.rows[3].count, "photons");
}

TEST_F(ClaimFile, FaultsAreToldWithTheirPlace) {
    const std::vector<std::array<const char*, 3>> faults = {
        {"frames: 5", "frame: 5", "frame: unknown key; did you mean 'frames'?"},
        {"source: A paper, figure 1\n", "", "the key 'source' is missing"},
        {"dapple_claim: 1", "dapple_claim: 2", "this program reads version 1"},
        {"5,1-3", "1:3", "write 1-10x2"},
        {"figure: l1,", "figure: l2,", "there is no figure 'l2'; did you mean 'l1'?"},
        {"of: wide, over: narrow, claimed: {at_m", "of: wid, over: narrow, claimed: {at_m",
         "there is no run 'wid'; did you mean 'wide'?"},
        {"narrow against wide", "narrow against wise", "there is no run 'wise'"},
        {"region: near", "region: ner", "there is no region 'ner'; did you mean 'near'?"},
        {"at_most: 1}", "at_mots: 1}", "did you mean 'at_most'?"},
        {"[0.9, 1]", "[1, 0.9]", "the least comes first"},
        {"[0.9, 1]", "[1]", "expected [least, most]"},
        {"[0.9, 1]", "[0.9, 1.01]", "rows[0].expected: the verdict would turn within it unseen"},
        {"{at_most: 1}", "{at_least: 0.95}", "the verdict would turn within it unseen"},
        {", because: so", "", "it needs 'expected' and 'because'"},
        {"at_least: 0.5, at_most: 0.6}", "at_most: 1}, expected: [0, 1]", "another on every machine"},
        {"count: photons, ", "", "'count' names"},
        {"figure: count,", "figure: l1,", "'count' names"},
        {"figure: cpu", "figure: memory", "only cpu and wall"},
        {"reference: {caustics: {method: sliced_beams}}\n", "", "an error needs the key 'reference'"},
        {"750 cm", "7.5 kg", "kg"},
        {"0.5, 1, 1]", "0.5, 1, 2]", "must be 0 to 1"},
        {"0.5, 1, 1]", "0.5]", "expected [left, top, right, bottom]"},
        {"  wide: {", "  wi/de: {", "a run's name is that of a folder"},
        {"  narrow: {}", "  reference: {}", "a key of its own"},
        {"  narrow: {}", "  narrow: 3", "expected a map of keys"},
        {"figure: l1, of: wide, over: [ref", "figure: bias, of: wide, over: [ref", "add in squares"},
        {"figure: count, count: photons, of: wide,", "figure: bias, of: reference,", "its noise only"},
        {"figure: l1, region: near", "figure: flip, region: near", "FLIP is that of whole pictures"},
    };
    for (const auto& [from, to, message] : faults)
        EXPECT_THAT(fault(from, to), HasSubstr(message)) << from << " -> " << to;
    EXPECT_THAT(fault("figure: l1, region", "figure: l2, region"), HasSubstr("claim.yaml:15:"));
    // All at once.
    EXPECT_THAT(fault("figure: l1, region: near", "figure: l2, region: ner"), HasSubstr("2 faults"));
}

RowResult found(const ClaimRow& row, double value) {
    RowResult result;
    result.state = RowResult::State::reported;
    result.margin = claim_margin(row, value);
    return result;
}

TEST(ClaimVerdict, IsTheFactorToWhatIsClaimed) {
    ClaimRow row;
    EXPECT_EQ(verdict_of(found(row, 3)), "–");
    row.at_most = 2;
    EXPECT_EQ(verdict_of(found(row, 0.5)), "holds by 4.00");
    EXPECT_EQ(verdict_of(found(row, 2)), "holds by 1.00");
    EXPECT_EQ(verdict_of(found(row, 3)), "fails by 1.50");
    EXPECT_EQ(verdict_of(found(row, 0)), "holds");
    row.at_least = 1;
    EXPECT_EQ(verdict_of(found(row, 1.6)), "holds by 1.25");
    EXPECT_EQ(verdict_of(found(row, 1.25)), "holds by 1.25");
    EXPECT_EQ(verdict_of(found(row, 0.5)), "fails by 2.00");
    EXPECT_EQ(verdict_of(found(row, 0)), "fails");
    row.at_most.reset();
    EXPECT_EQ(verdict_of(found(row, 8)), "holds by 8.00");
}

TEST_F(ClaimFile, ReportsEveryRow) {
    using enum RowResult::State;
    const Claim claim = read(kClaim);
    ClaimResult result{claim, {}};
    for (const auto state : {changed, as_recorded, reported, failed}) {
        RowResult& row = result.rows.emplace_back();
        row.state = state;
        row.of = 0.03;
        row.over = 0.02;
        row.value = 1.5;
        row.margin = claim_margin(claim.rows[result.rows.size() - 1], row.value);
    }
    result.rows[3].failure = "the stats count no <photons>";
    BenchResult bench;
    bench.claims = {result};
    EXPECT_THAT(claim_failures(bench.claims),
                ElementsAre("claim: first: CHANGED: 1.5, expected 0.9 to 1",
                            "claim: fourth: no figure: the stats count no <photons>"));
    const std::string text = bench_text(bench);
    for (const char* part : {"(A paper, figure 1)", "fails by 1.50", "CHANGED", "as recorded", "FAILED",
                             "fails by 2.50", "0.5 to 0.6"})
        EXPECT_THAT(text, HasSubstr(part));
    const std::string html = bench_html(bench);
    for (const char* part :
         {"Bench of claims", "no &lt;photons&gt;", "of splatting, denoise",
          "root of squares of reference, narrow against wide", "caustics.inner_size=7.5 m"})
        EXPECT_THAT(html, HasSubstr(part));
    const auto rows = nlohmann::json::parse(bench_json(bench)).at("claims")[0].at("rows");
    ASSERT_EQ(rows.size(), 4u);
    EXPECT_EQ(rows[0].at("state"), "CHANGED");
    EXPECT_EQ(rows[0].at("value"), 1.5);
    EXPECT_EQ(rows[0].at("at_most"), 1);
    EXPECT_TRUE(rows[3].at("value").is_null());
    const std::string csv = bench_csv(bench);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
}

TEST_F(ClaimFile, PicturesThatARowComparesAreOfOneSize) {
    const auto message = [&](const std::string& rows) -> std::string {
        try {
            check_runs(read("dapple_claim: 1\nsource: a paper\nclaim: a claim\ntimeline: " +
                            std::string(DAPPLE_SOURCE_DIR) +
                            "/tests/end_to_end/small.yaml\nframes: 1\n"
                            "settings: {clip.resolution: [32, 18]}\nreference: {}\n"
                            "runs:\n  alike: {}\n  large: {clip.resolution: [64, 36]}\nrows:\n" +
                            rows));
        } catch (const Error& error) {
            return error.what();
        }
        return "none";
    };
    const std::string expected = ", expected: [0, 1], because: so}\n";
    EXPECT_THAT(message("  - {says: a, figure: l1, of: alike, over: reference" + expected), "none");
    EXPECT_THAT(message("  - {says: a, figure: count, count: photons, of: large, over: alike" + expected),
                "none");
    EXPECT_THAT(message("  - {says: a, figure: l1, of: large against large" + expected), "none");
    EXPECT_THAT(message("  - {says: a, figure: l1, of: large" + expected),
                HasSubstr("a: large: 64 x 36 pixels; errors need the 32 x 18 of reference"));
    EXPECT_THAT(message("  - {says: a, figure: l1, of: alike, over: alike against large" + expected),
                HasSubstr("a: alike: 32 x 18 pixels; errors need the 64 x 36 of large"));
}

TEST(BenchClaims, AllThatStandInTheSequencesCanBeRun) {
    std::size_t files = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(DAPPLE_SOURCE_DIR) + "/sequences/claims")) {
        if (entry.path().extension() != ".yaml") continue;
        SCOPED_TRACE(entry.path().string());
        const Claim claim = read_claim(entry.path().string());
        check_runs(claim);
        EXPECT_FALSE(claim.rows.empty());
        ++files;
    }
    EXPECT_GE(files, 9u);
}

}  // namespace
}  // namespace dapple::judge
