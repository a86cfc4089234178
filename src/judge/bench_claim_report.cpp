#include "judge/bench_claim_report.h"

#include "judge/text.h"
#include "run/json_number.h"

namespace dapple::judge {
namespace {

using report::HtmlPage;
using run::json_number;
using Json = nlohmann::ordered_json;
using State = RowResult::State;

std::string term_text(const ClaimTerm& term) {
    return term.run + (term.against == kClaimReference ? "" : " against " + term.against);
}

/// "a", or "√(a² + b²)".
std::string over_text(const ClaimRow& row) {
    std::string text;
    for (const ClaimTerm& term : row.over) text += (text.empty() ? "" : ", ") + term_text(term);
    return row.over.size() > 1 ? "root of squares of " + text : text;
}

std::string figure_text(const ClaimRow& row) {
    std::string text(row.figure->name);
    if (!row.count.empty()) text += " " + row.count;
    if (!row.region.empty()) text += ", " + row.region;
    for (std::size_t i = 0; i < row.passes.size(); ++i) text += (i == 0 ? " of " : ", ") + row.passes[i];
    return text;
}

std::string number(double value) {
    return formatted("%.4g", value);
}

std::string claimed_text(const ClaimRow& row) {
    if (row.at_least && row.at_most) return number(*row.at_least) + " to " + number(*row.at_most);
    if (row.at_least) return ">= " + number(*row.at_least);
    if (row.at_most) return "<= " + number(*row.at_most);
    return "";
}

std::string expected_text(const ClaimRow& row) {
    return row.expected ? number(row.expected->first) + " to " + number(row.expected->second) : "";
}

std::string state_text(State state) {
    switch (state) {
        case State::as_recorded:
            return "as recorded";
        case State::changed:
            return "CHANGED";
        case State::reported:
            return "reported";
        case State::failed:
            return "FAILED";
    }
    return "";
}

bool is_bad(State state) {
    return state == State::changed || state == State::failed;
}

}  // namespace

std::string claims_text(const std::vector<ClaimResult>& claims) {
    std::string text;
    for (const ClaimResult& result : claims) {
        text += (text.empty() ? "" : "\n") + result.claim.name + ": " + result.claim.claim + "\n(" +
                result.claim.source + ")\n";
        std::vector<std::vector<std::string>> rows = {
            {"row", "figure", "of", "over", "is", "claimed", "verdict", "expected", ""}};
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            const ClaimRow& row = result.claim.rows[i];
            const RowResult& found = result.rows[i];
            const bool none = found.state == State::failed;
            rows.push_back({row.says, std::string(row.figure->name), none ? "" : number(found.of),
                            none || row.over.empty() ? "" : number(found.over),
                            none ? "" : number(found.value), claimed_text(row), verdict_of(found),
                            expected_text(row), state_text(found.state)});
        }
        text += aligned(rows);
    }
    return text;
}

std::string claims_csv(const std::vector<ClaimResult>& claims) {
    std::string text =
        "claim,row,figure,of,over,value_of,value_over,value,at_least,at_most,margin,verdict,expected_least,"
        "expected_most,state\n";
    const auto optional = [](const std::optional<double>& value) {
        return value ? formatted("%.6g", *value) : std::string();
    };
    for (const ClaimResult& result : claims) {
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            const ClaimRow& row = result.claim.rows[i];
            const RowResult& found = result.rows[i];
            const auto value = [&](double figure) {
                return found.state == State::failed ? std::string() : formatted("%.6g", figure);
            };
            text += csv_quoted(result.claim.name) + "," + csv_quoted(row.says) + "," +
                    csv_quoted(figure_text(row)) + "," + csv_quoted(term_text(row.of)) + "," +
                    csv_quoted(over_text(row)) + "," + value(found.of) + "," + value(found.over) + "," +
                    value(found.value) + "," + optional(row.at_least) + "," + optional(row.at_most) + "," +
                    optional(found.margin) + "," + csv_quoted(verdict_of(found)) + "," +
                    (row.expected ? formatted("%.6g", row.expected->first) + "," +
                                        formatted("%.6g", row.expected->second)
                                  : ",") +
                    "," + state_text(found.state) + "\n";
        }
    }
    return text;
}

Json claims_json(const std::vector<ClaimResult>& claims) {
    Json list = Json::array();
    const auto optional = [](const std::optional<double>& value) {
        return value ? json_number(*value) : Json(nullptr);
    };
    for (const ClaimResult& result : claims) {
        const Claim& claim = result.claim;
        Json runs = Json::object(), rows = Json::array();
        if (claim.reference) runs[kClaimReference] = claim.reference->overrides;
        for (const ClaimRun& run : claim.runs) runs[run.name] = run.overrides;
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            const ClaimRow& row = claim.rows[i];
            const RowResult& found = result.rows[i];
            const bool none = found.state == State::failed;
            const auto value = [&](double figure) { return none ? Json(nullptr) : json_number(figure); };
            rows.push_back(
                {{"says", row.says},
                 {"figure", figure_text(row)},
                 {"of", term_text(row.of)},
                 {"over", over_text(row)},
                 {"value_of", value(found.of)},
                 {"value_over", value(found.over)},
                 {"value", value(found.value)},
                 {"at_least", optional(row.at_least)},
                 {"at_most", optional(row.at_most)},
                 {"margin", optional(found.margin)},
                 {"verdict", verdict_of(found)},
                 {"expected", row.expected ? Json{row.expected->first, row.expected->second} : Json(nullptr)},
                 {"state", state_text(found.state)},
                 {"because", row.because}});
        }
        list.push_back({{"name", claim.name},
                        {"source", claim.source},
                        {"claim", claim.claim},
                        {"timeline", claim.timeline},
                        {"frames", frames_text(claim.frames)},
                        {"layer", claim.layer},
                        {"runs", runs},
                        {"rows", rows}});
    }
    return list;
}

void add_claims(HtmlPage& page, const std::vector<ClaimResult>& claims) {
    using Tone = HtmlPage::Tone;
    page.heading("Claims");
    for (const std::string& failure : claim_failures(claims)) page.verdict(failure, Tone::bad);
    for (const ClaimResult& result : claims) {
        const Claim& claim = result.claim;
        page.heading(claim.name);
        page.paragraph(claim.claim + " (" + claim.source + ")");
        std::vector<std::vector<HtmlPage::Cell>> rows;
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            const ClaimRow& row = claim.rows[i];
            const RowResult& found = result.rows[i];
            const bool none = found.state == State::failed;
            const Tone verdict = !found.margin ? Tone::plain : *found.margin >= 1 ? Tone::good : Tone::bad;
            const auto value = [&](double figure) { return none ? "" : number(figure); };
            rows.push_back({{row.says},
                            {figure_text(row)},
                            {term_text(row.of)},
                            {value(found.of)},
                            {over_text(row)},
                            {row.over.empty() ? "" : value(found.over)},
                            {value(found.value)},
                            {claimed_text(row)},
                            {verdict_of(found), verdict},
                            {expected_text(row)},
                            {state_text(found.state), is_bad(found.state) ? Tone::bad : Tone::plain},
                            {row.because}});
        }
        page.table({"row", "figure", "of", "", "over", "", "is", "claimed", "verdict", "expected", "", "why"},
                   rows);
        std::vector<std::vector<HtmlPage::Cell>> runs;
        const auto add = [&](const ClaimRun& run) {
            std::string overrides;
            for (const std::string& text : run.overrides) overrides += (overrides.empty() ? "" : "; ") + text;
            runs.push_back({{run.name}, {overrides}});
        };
        if (claim.reference) add(*claim.reference);
        for (const ClaimRun& run : claim.runs) add(run);
        page.paragraph(claim.timeline + ", frames " + frames_text(claim.frames) + ", layer " + claim.layer);
        page.table({"run", "overrides"}, runs);
    }
    page.paragraph(
        "“Is”: the figure of one run, or its ratio to that of another (of several: to the root of the sum of "
        "their squares). The verdict tells by what factor the source's claim holds or fails here. What "
        "repeats is compared with what is expected; times and memory are medians on this machine, and only "
        "reported. Errors are shares of the mean of what they are against.");
    std::vector<std::vector<HtmlPage::Cell>> figures;
    for (const Figure& figure : claim_figures())
        figures.push_back({{std::string(figure.name)}, {std::string(figure.meaning)}});
    page.table({"figure", "what it is"}, figures);
}

std::vector<std::string> claim_failures(const std::vector<ClaimResult>& claims) {
    std::vector<std::string> lines;
    for (const ClaimResult& result : claims) {
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            const ClaimRow& row = result.claim.rows[i];
            const RowResult& found = result.rows[i];
            const std::string head = result.claim.name + ": " + row.says + ": ";
            if (found.state == State::changed)
                lines.push_back(head + "CHANGED: " + number(found.value) + ", expected " +
                                expected_text(row));
            if (found.state == State::failed) lines.push_back(head + verdict_of(found));
        }
    }
    return lines;
}

}  // namespace dapple::judge
