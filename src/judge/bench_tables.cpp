// The figures of a bench as CSV, JSON and text.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "judge/bench_claim_report.h"
#include "judge/bench_error_times.h"
#include "judge/bench_report.h"
#include "judge/text.h"
#include "run/json_number.h"

namespace dapple::judge {
namespace {

using run::json_number;
using Json = nlohmann::ordered_json;

std::string number(double value) {
    return formatted("%.6g", value);
}

std::string number(const std::optional<double>& value) {
    return value ? number(*value) : "";
}

Json to_json(const std::optional<double>& value) {
    return value ? json_number(*value) : Json(nullptr);
}

Json to_json(const Spread& spread) {
    return {{"median", spread.median}, {"least", spread.least}, {"most", spread.most}};
}

Json to_json(const Timing& timing) {
    Json passes = Json::array();
    for (const Timing::Pass& pass : timing.passes)
        passes.push_back(
            {{"name", pass.name}, {"wall_s", to_json(pass.wall_s)}, {"cpu_s", to_json(pass.cpu_s)}});
    return {{"wall_s", to_json(timing.wall_s)},  {"cpu_s", to_json(timing.cpu_s)},
            {"warm_up_s", timing.warm_up_s},     {"start_up_s", timing.start_up_s},
            {"peak_memory", timing.peak_memory}, {"passes", passes}};
}

Json to_json(const ClipErrors& errors) {
    return {{"l1", json_number(errors.l1)},
            {"l1_inside", json_number(errors.l1_inside)},
            {"rmse", json_number(errors.rmse)},
            {"rmse_less_noise", json_number(errors.rmse_less_noise)},
            {"block_rmse", json_number(errors.block_rmse)},
            {"block_rmse_less_noise", json_number(errors.block_rmse_less_noise)},
            {"bias", json_number(errors.bias)},
            {"energy", json_number(errors.energy)},
            {"flip", json_number(errors.flip)},
            {"flicker", to_json(errors.flicker)},
            {"flicker_less_noise", to_json(errors.flicker_less_noise)},
            {"compared", errors.compared},
            {"inside", errors.inside}};
}

Json to_json(const TimeToError& time) {
    using enum TimeToError::State;
    const char* state = time.state == reached       ? "reached"
                        : time.state == at_most     ? "at_most"
                        : time.state == not_reached ? "not_reached"
                                                    : "not_known";
    const bool has_time = time.state == reached || time.state == at_most;
    return {{"state", state}, {"seconds", has_time ? Json(time.seconds) : Json(nullptr)}};
}

/// `time` gives the time of what, by a clock, to an error of a kind.
template <class Time>
Json times_to_error(bool scatters, const Time& time) {
    Json times = Json::array();
    for (const double error : kErrorsOfInterest) {
        Json entry = {{"error", error}};
        for (const Clock clock : {Clock::wall, Clock::cpu}) {
            Json& of_clock = entry[clock == Clock::wall ? "wall" : "cpu"];
            of_clock = {{"l1_inside", to_json(time(Judged::layer, clock, kL1Inside, error))},
                        {"rmse_less_noise", to_json(time(Judged::layer, clock, kRmse, error))}};
            if (scatters) of_clock["scattered_l1"] = to_json(time(Judged::scattered, clock, kL1, error));
        }
        times.push_back(std::move(entry));
    }
    return times;
}

Json to_json(const RungResult& result, const BenchResult& all) {
    const Ladder& ladder = all.ladders[result.rung.ladder];
    Json json = {{"name", result.rung.name},
                 {"method", ladder.method},
                 {"key", ladder.key},
                 {"value", result.rung.value},
                 {"overrides", result.rung.overrides}};
    if (!result.failure.empty()) {
        json["failure"] = result.failure;
        return json;
    }
    json["repeats"] = result.repeats;
    json["same_bits"] = result.timing.same_bits;
    json["non_finite"] = result.timing.non_finite;
    json["partly"] = result.partly;
    json["timing"] = to_json(result.timing);
    json["errors"] = to_json(result.judged.errors);
    if (all.reference && all.reference->scattered)
        json["scattered"] = result.scattered ? to_json(*result.scattered) : Json(nullptr);
    return json;
}

Json to_json(const HardCase& hard) {
    Json verdicts = Json::array();
    for (const CaseVerdict& verdict : hard.verdicts) {
        verdicts.push_back({{"method", verdict.method},
                            {"verdict", to_string(verdict.verdict)},
                            {"reason", verdict.reason},
                            {"exit_code", verdict.exit_code},
                            {"non_finite", verdict.non_finite},
                            {"energy", json_number(verdict.energy)},
                            {"l1", json_number(verdict.l1)},
                            {"lost_w", verdict.lost},
                            {"wall_s", verdict.wall_s}});
        if (!verdict.scattered) continue;
        const ScatteredVerdict& s = *verdict.scattered;
        verdicts.back()["scattered"] = {{"verdict", to_string(s.verdict)},
                                        {"reason", s.reason},
                                        {"energy", json_number(s.energy)},
                                        {"l1", json_number(s.l1)}};
    }
    return {{"name", hard.name},
            {"description", hard.description},
            {"reference", hard.reference},
            {"verdicts", verdicts}};
}

}  // namespace

std::string bench_csv(const BenchResult& result) {
    if (!result.claims.empty()) return claims_csv(result.claims);
    std::string text =
        "run,method,key,value,wall_s,wall_least_s,wall_most_s,cpu_s,cpu_least_s,cpu_most_s,warm_up_s,start_"
        "up_s,"
        "peak_memory,repeats,same_bits,l1,l1_inside,rmse,rmse_less_noise,block_rmse,block_rmse_less_noise,"
        "bias,"
        "energy,flip,flicker,flicker_less_noise,compared,non_finite,s_l1,s_rmse,s_rmse_less_noise,s_"
        "block_rmse_less_noise,"
        "s_bias,s_flicker,s_flicker_less_noise,failure\n";
    for (const RungResult& rung : result.rungs) {
        const Ladder& ladder = result.ladders[rung.rung.ladder];
        text += csv_quoted(rung.rung.name) + "," + ladder.method + "," + csv_quoted(ladder.key) + "," +
                csv_quoted(rung.rung.value);
        if (!rung.failure.empty()) {
            text += std::string(32, ',') + csv_quoted(rung.failure) + "\n";
            continue;
        }
        const Timing& t = rung.timing;
        const ClipErrors& e = rung.judged.errors;
        for (const Spread& spread : {t.wall_s, t.cpu_s})
            text += "," + number(spread.median) + "," + number(spread.least) + "," + number(spread.most);
        text += "," + number(t.warm_up_s) + "," + number(t.start_up_s) + "," +
                formatted("%.0f", t.peak_memory) + "," + std::to_string(rung.repeats) + "," +
                (t.same_bits ? "1" : "0");
        for (const double value : {e.l1, e.l1_inside, e.rmse, e.rmse_less_noise, e.block_rmse,
                                   e.block_rmse_less_noise, e.bias, e.energy, e.flip})
            text += "," + number(value);
        text += "," + number(e.flicker) + "," + number(e.flicker_less_noise) + "," + number(e.compared) +
                "," + std::to_string(t.non_finite);
        if (rung.scattered) {
            const ClipErrors& s = *rung.scattered;
            for (const double value : {s.l1, s.rmse, s.rmse_less_noise, s.block_rmse_less_noise, s.bias})
                text += "," + number(value);
            text += "," + number(s.flicker) + "," + number(s.flicker_less_noise) + ",\n";
        } else {
            text += std::string(8, ',') + "\n";
        }
    }
    return text;
}

std::string bench_json(const BenchResult& result) {
    Json json = {{"format", 1}};
    Json provenance = Json::object();
    for (const auto& [name, text] : result.provenance) provenance[name] = text;
    json["provenance"] = provenance;
    if (result.reference) {
        const ReferenceResult& r = *result.reference;
        json["timeline"] = result.timeline;
        json["frames"] = result.frames;
        json["layer"] = result.layer;
        json["size"] = {result.width, result.height};
        json["samples"] = result.samples;
        json["definitions"] = bench_definitions(result);
        json["reference"] = {{"job", r.job},
                             {"folder", r.folder},
                             {"mean", r.noise.mean},
                             {"noise_rmse", to_json(r.noise.rmse)},
                             {"noise_l1", to_json(r.noise.l1)},
                             {"standard_error", r.standard_error},
                             {"wall_s", r.wall_s},
                             {"cpu_s", r.cpu_s},
                             {"partly", r.partly}};
        json["reference"]["time_to_error"] = times_to_error(
            r.scattered.has_value(), [&](Judged what, Clock clock, const ErrorKind& kind, double e) {
                return reference_time_to(result, what, clock, kind, e);
            });
        if (r.scattered)
            json["reference"]["scattered"] = {{"mean", r.scattered->mean},
                                              {"noise_rmse", to_json(r.scattered->rmse)},
                                              {"noise_l1", to_json(r.scattered->l1)}};
        json["exposures"] = {{"start", result.exposures.start},
                             {"stop", result.exposures.stop},
                             {"count", result.exposures.count}};
        Json ladders = Json::array(), rungs = Json::array();
        for (std::size_t i = 0; i < result.ladders.size(); ++i) {
            ladders.push_back({{"method", result.ladders[i].method},
                               {"key", result.ladders[i].key},
                               {"values", result.ladders[i].values},
                               {"time_to_error",
                                times_to_error(r.scattered.has_value(), [&](Judged what, Clock clock,
                                                                            const ErrorKind& kind, double e) {
                                    return time_to(result, i, what, clock, kind, e);
                                })}});
        }
        for (const RungResult& rung : result.rungs) rungs.push_back(to_json(rung, result));
        json["ladders"] = ladders;
        json["runs"] = rungs;
    }
    if (!result.hard_cases.empty()) {
        Json cases = Json::array();
        for (const HardCase& hard : result.hard_cases) cases.push_back(to_json(hard));
        json["hard_cases"] = cases;
    }
    if (!result.claims.empty()) json["claims"] = claims_json(result.claims);
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> case_failures(const BenchResult& result) {
    std::vector<std::string> lines;
    for (const HardCase& hard : result.hard_cases) {
        for (const CaseVerdict& verdict : hard.verdicts) {
            const std::string what = hard.name + ", " + verdict.method;
            if (verdict.verdict == Verdict::fails) lines.push_back(what + " fails: " + verdict.reason);
            if (verdict.scattered && verdict.scattered->verdict == Verdict::fails)
                lines.push_back(what + " fails in S: " + verdict.scattered->reason);
        }
    }
    return lines;
}

std::string bench_text(const BenchResult& result) {
    std::string text;
    if (result.reference) {
        std::vector<std::vector<std::string>> rows = {{"run", "s a frame", "least", "most", "CPU s", "MiB",
                                                       "L1 %", "inside %", "RMSE %", "4x4 %", "bias %",
                                                       "energy %", "FLIP", "flicker"}};
        const bool scatters = result.reference->scattered.has_value();
        if (scatters) rows[0].insert(rows[0].end(), {"S: L1 %", "RMSE %"});
        for (const RungResult& rung : result.rungs) {
            if (!rung.failure.empty()) {
                rows.push_back({rung.rung.name, "failed"});
                continue;
            }
            const Timing& t = rung.timing;
            const ClipErrors& e = rung.judged.errors;
            rows.push_back({rung.rung.name, formatted("%.3f", t.wall_s.median),
                            formatted("%.3f", t.wall_s.least), formatted("%.3f", t.wall_s.most),
                            formatted("%.3f", t.cpu_s.median), formatted("%.0f", t.peak_memory / (1 << 20)),
                            percent(e.l1), percent(e.l1_inside), percent(e.rmse_less_noise),
                            percent(e.block_rmse_less_noise), percent(e.bias), percent(e.energy),
                            formatted("%.4f", e.flip),
                            e.flicker ? formatted("%.2e", e.flicker_less_noise.value_or(*e.flicker)) : "-"});
            if (!scatters) continue;
            const std::optional<ClipErrors>& s = rung.scattered;
            rows.back().push_back(s ? percent(s->l1) : "-");
            rows.back().push_back(s ? percent(s->rmse_less_noise) : "-");
        }
        text += aligned(rows);
        const ReferenceNoise& noise = result.reference->noise;
        if (noise.rmse)
            text += "reference: noise " + percent(*noise.rmse) + " % (RMSE), " + percent(*noise.l1) +
                    " % (L1); " + formatted("%.1f s a frame\n", result.reference->wall_s);
        if (scatters && result.reference->scattered->rmse)
            text += "scattered light: noise " + percent(*result.reference->scattered->rmse) + " % (RMSE), " +
                    percent(*result.reference->scattered->l1) + " % (L1)\n";
        rows = times_to_errors(result);
        rows.insert(rows.begin(), {"time of a frame to", "L1 5 %", "2 %", "1 %", "RMSE 5 %", "2 %", "1 %"});
        if (scatters) rows[0].insert(rows[0].end(), {"S: L1 5 %", "2 %", "1 %"});
        text += "\n" + aligned(rows);
    }
    text += claims_text(result.claims);
    std::size_t verdicts = 0, counts[3] = {};
    for (const HardCase& hard : result.hard_cases) {
        for (const CaseVerdict& verdict : hard.verdicts) {
            ++verdicts;
            ++counts[static_cast<int>(verdict.verdict)];
            if (!verdict.scattered) continue;
            ++verdicts;
            ++counts[static_cast<int>(verdict.scattered->verdict)];
        }
    }
    if (verdicts > 0) {
        text += (text.empty() ? "" : "\n") + std::to_string(result.hard_cases.size()) + " hard cases, " +
                std::to_string(verdicts) + " verdicts: " + std::to_string(counts[0]) + " hold, " +
                std::to_string(counts[1]) + " differ as the plan says, " + std::to_string(counts[2]) +
                " fail\n";
        for (const std::string& failure : case_failures(result)) text += failure + "\n";
    }
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
}

}  // namespace dapple::judge
