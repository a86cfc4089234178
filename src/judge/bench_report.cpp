#include "judge/bench_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "judge/bench_claim_report.h"
#include "judge/bench_error_times.h"
#include "judge/text.h"
#include "report/canvas.h"
#include "report/heat_map.h"
#include "report/html_page.h"
#include "report/plot.h"
#include "run/memory_budget.h"

namespace dapple::judge {
namespace {

using report::HtmlPage;
using Cell = HtmlPage::Cell;
using Tone = HtmlPage::Tone;

/// Heat maps: error that is shown as the brightest, over the reference's mean.
constexpr double kFullError = 0.2;

std::string seconds(const Spread& spread) {
    return formatted("%.3f", spread.median) + " (" + formatted("%.3f", spread.least) + "–" +
           formatted("%.3f", spread.most) + ")";
}

std::vector<const RungResult*> rungs_of(const BenchResult& result, std::size_t ladder) {
    std::vector<const RungResult*> rungs;
    for (const RungResult& rung : result.rungs)
        if (rung.rung.ladder == ladder && rung.failure.empty()) rungs.push_back(&rung);
    return rungs;
}

/// An error of 0 is one too small to be told, which has no place on a logarithmic axis: it is drawn at the
/// reference's noise, or at the least other error where that is smaller. Returns what has to be said of it.
std::string draw_zeros(report::Plot& plot, double noise) {
    double floor = noise > 0 ? noise : std::numeric_limits<double>::infinity();
    for (const report::Series& series : plot.series)
        for (const auto& [at, value] : series.points)
            if (value > 0) floor = std::min(floor, value);
    std::string names;
    for (report::Series& series : plot.series) {
        for (auto& [at, value] : series.points) {
            if (value != 0 || std::isinf(floor)) continue;
            value = floor;
            names += (names.empty() ? "" : "; ") + series.name + " at " + formatted("%.3f s", at);
        }
    }
    if (names.empty()) return "";
    return plot.title + ": too small to be told from the reference's noise, drawn at " +
           formatted("%.2g", floor) + ": " + names + ".";
}

void add_plot(HtmlPage& page, const BenchResult& result, const char* title, Judged what, Clock clock,
              const ErrorKind& kind) {
    report::Plot plot{.title = title,
                      .x_label = clock == Clock::wall ? "wall s a frame" : "CPU s a frame",
                      .y_label = "share of the mean"};
    plot.log_x = plot.log_y = true;
    for (std::size_t i = 0; i < result.ladders.size(); ++i)
        plot.series.push_back(
            {result.ladders[i].name(), times_and_errors(result, i, what, clock, kind), true, true});
    const TimesAndErrors reference = reference_times_and_errors(result, what, clock, kind);
    const double noise = reference.empty() ? 0 : reference.back().second;
    if (noise > 0) plot.limits.emplace_back(noise, "the reference's noise");
    const std::string drawn = draw_zeros(plot, noise);
    if (!reference.empty()) plot.series.push_back({"reference, its noise", reference, true, false});
    page.plot(report::svg(plot));
    if (!drawn.empty()) page.paragraph(drawn);
}

void add_errors(HtmlPage& page, const BenchResult& result) {
    page.heading("Errors");
    const std::vector<std::string> header = {"run",    "L1 %",     "L1 inside %", "RMSE %",  "4×4 %",
                                             "bias %", "energy %", "HDR-FLIP",    "flicker", "compared %"};
    std::vector<std::vector<Cell>> rows;
    for (const RungResult& rung : result.rungs) {
        if (!rung.failure.empty()) {
            rows.push_back({{rung.rung.name}, {"failed", Tone::bad}});
            rows.back().resize(header.size());
            continue;
        }
        const ClipErrors& e = rung.judged.errors;
        rows.push_back({{rung.rung.name},
                        {percent(e.l1)},
                        {percent(e.l1_inside)},
                        {percent(e.rmse_less_noise)},
                        {percent(e.block_rmse_less_noise)},
                        {percent(e.bias)},
                        {percent(e.energy)},
                        {formatted("%.4f", e.flip)},
                        {e.flicker ? formatted("%.5f", e.flicker_less_noise.value_or(*e.flicker)) : "–"},
                        {formatted("%.1f", 100 * e.compared)}});
    }
    page.table(header, rows);
    for (const std::string& definition : bench_definitions(result)) page.paragraph(definition);
}

void add_scattered(HtmlPage& page, const BenchResult& result) {
    const std::optional<ReferenceNoise>& noise = result.reference->scattered;
    if (!noise) return;
    page.heading("Scattered light");
    add_plot(page, result, "Relative L1 of scattered light", Judged::scattered, Clock::wall, kL1);
    add_plot(page, result, "Relative RMSE of scattered light, less the reference's noise", Judged::scattered,
             Clock::wall, kRmse);
    std::vector<std::vector<Cell>> rows;
    for (const RungResult& rung : result.rungs) {
        if (!rung.failure.empty()) continue;
        if (!rung.scattered) {
            rows.push_back({{rung.rung.name}, {"none", Tone::bad}, {}, {}, {}, {}});
            continue;
        }
        const ClipErrors& e = *rung.scattered;
        rows.push_back({{rung.rung.name},
                        {percent(e.l1)},
                        {percent(e.rmse_less_noise)},
                        {percent(e.block_rmse_less_noise)},
                        {percent(e.bias)},
                        {e.flicker ? formatted("%.5f", e.flicker_less_noise.value_or(*e.flicker)) : "–"}});
    }
    page.table({"run", "L1 %", "RMSE %", "4×4 %", "bias %", "flicker"}, rows);
    page.paragraph(
        "S: light that met something specular and is then scattered once on its way to the camera (layer " +
        std::string(kScatteredLayer) + "), over all pixels. " +
        (noise->rmse ? "The reference's own noise, as its camera paths' first branches know it, is " +
                           percent(*noise->rmse) + " % (RMSE) and about " + percent(*noise->l1) + " % (L1)."
                     : std::string("The reference's own noise is not known; nothing is taken off.")));
}

void add_times(HtmlPage& page, const BenchResult& result) {
    page.heading("Times");
    std::vector<std::vector<Cell>> rows;
    for (const RungResult& rung : result.rungs) {
        if (!rung.failure.empty()) continue;
        const Timing& t = rung.timing;
        rows.push_back({{rung.rung.name},
                        {seconds(t.wall_s)},
                        {seconds(t.cpu_s)},
                        {formatted("%.3f", t.warm_up_s)},
                        {formatted("%.3f", t.start_up_s)},
                        {run::format_bytes(t.peak_memory)},
                        {std::to_string(rung.repeats)},
                        {t.same_bits ? "same bits" : "other bits", t.same_bits ? Tone::good : Tone::bad}});
    }
    page.table({"run", "wall s a frame", "CPU s a frame", "warm-up s", "start-up s", "peak memory", "repeats",
                "their pictures"},
               rows);
    page.paragraph(
        "Medians over repeats, mean over frames, without writing the files and temporal figures, which are "
        "the same for all; in brackets the same times the "
        "least "
        "and the largest ratio of one frame of one repeat to its median. Each repeat is a process of its own "
        "that "
        "renders one frame more before the others: warm-up is what that one took beyond them (shaders among "
        "it), "
        "start-up the process outside its frames. Repeats of all runs take turns.");

    std::vector<std::vector<Cell>> errors;
    for (const std::vector<std::string>& row : times_to_errors(result)) {
        errors.emplace_back();
        for (const std::string& text : row) errors.back().push_back({text});
    }
    page.heading("Time to an error");
    std::vector<std::string> header = {"a frame", "L1 inside 5 %", "2 %", "1 %", "RMSE 5 %", "2 %", "1 %"};
    if (result.reference->scattered) header.insert(header.end(), {"S: L1 5 %", "2 %", "1 %"});
    page.table(header, errors);
    page.paragraph(
        "Along straight lines in log(time), log(error) between neighbouring rungs; “≤” where the cheapest "
        "rung is there already, or one whose RMSE is below the reference's noise; the reference "
        "by its noise, as 1 / √time.");
}

void add_passes(HtmlPage& page, const BenchResult& result) {
    page.heading("Passes");
    for (std::size_t i = 0; i < result.ladders.size(); ++i) {
        const auto rungs = rungs_of(result, i);
        if (rungs.empty()) continue;
        std::vector<std::string> header = {result.ladders[i].name() + ": wall; CPU ms"};
        std::vector<std::string> names;
        for (const RungResult* rung : rungs) {
            header.push_back(rung->rung.value.empty() ? "as it is" : rung->rung.value);
            for (const Timing::Pass& pass : rung->timing.passes)
                if (std::find(names.begin(), names.end(), pass.name) == names.end())
                    names.push_back(pass.name);
        }
        std::vector<std::vector<Cell>> rows;
        for (const std::string& name : names) {
            std::vector<Cell> row = {{name}};
            for (const RungResult* rung : rungs) {
                const auto& passes = rung->timing.passes;
                const auto pass = std::find_if(passes.begin(), passes.end(),
                                               [&](const Timing::Pass& p) { return p.name == name; });
                row.push_back({pass == passes.end() ? "–"
                                                    : formatted("%.1f", 1e3 * pass->wall_s.median) + "; " +
                                                          formatted("%.1f", 1e3 * pass->cpu_s.median)});
            }
            rows.push_back(row);
        }
        page.table(header, rows);
    }
}

constexpr int kMapWidth = 320;  ///< of small pictures, at least

void add_maps(HtmlPage& page, const BenchResult& result) {
    page.heading("Where the error is");
    report::Canvas scale(420, 44, {24, 24, 28});
    report::draw_scale(scale, 10, 5, 400, 34, kFullError,
                       "|difference of luminance| / mean of the reference");
    page.picture(scale.width(), scale.height(), scale.rgb(), "the scale of all maps");
    for (const RungResult& rung : result.rungs) {
        if (!rung.failure.empty()) continue;
        const ErrorMap& map = rung.judged.map;
        const int factor = std::max(1, (kMapWidth + map.width - 1) / map.width);
        page.picture(
            factor * map.width, factor * map.height,
            report::enlarged(report::heat_map(map.values, kFullError), map.width, map.height, factor),
            rung.rung.name + ", frame " + std::to_string(map.frame));
    }
    page.paragraph("Magenta: not compared.");
}

void add_notes(HtmlPage& page, const BenchResult& result) {
    page.heading("What was done partly");
    std::vector<std::vector<Cell>> rows;
    const auto add = [&](const std::string& name, const std::vector<std::string>& reasons) {
        for (const std::string& reason : reasons) rows.push_back({{name}, {reason}});
    };
    add("reference", result.reference->partly);
    for (std::size_t i = 0; i < result.ladders.size(); ++i) {
        const auto rungs = rungs_of(result, i);
        if (!rungs.empty()) add(result.ladders[i].name(), rungs.front()->partly);
    }
    if (rows.empty())
        page.paragraph("Nothing: the plans of all runs are whole.");
    else
        page.table({"run", "plan"}, rows);
}

void add_hard_cases(HtmlPage& page, const BenchResult& result) {
    page.heading("Hard cases");
    for (const std::string& failure : case_failures(result)) page.verdict(failure, Tone::bad);
    std::vector<std::vector<Cell>> rows;
    for (const HardCase& hard : result.hard_cases) {
        for (const CaseVerdict& verdict : hard.verdicts) {
            const auto add = [&](const char* of, Verdict which, const std::string& reason) {
                const Tone tone = which == Verdict::holds   ? Tone::good
                                  : which == Verdict::named ? Tone::plain
                                                            : Tone::bad;
                rows.push_back({{hard.name + ": " + hard.description},
                                {verdict.method},
                                {of},
                                {to_string(which), tone},
                                {reason},
                                {formatted("%.3g", verdict.lost)},
                                {formatted("%.1f", verdict.wall_s)},
                                {hard.reference}});
            };
            add("E", verdict.verdict, verdict.reason);
            if (verdict.scattered) add("S", verdict.scattered->verdict, verdict.scattered->reason);
        }
    }
    page.table({"case", "method", "of", "verdict", "why", "lost by name, W", "s", "reference"}, rows);
    page.paragraph(
        "A case holds where the process ends well, no value is NaN or infinite, and the light of E over "
        "the picture is the reference's within " +
        percent(kEnergyTolerance) +
        " % and three standard errors of the reference; or where the input is refused by all, the "
        "reference too. “Named”: so where it answers, and the plan says what it leaves out. S, light that "
        "media scatter, is judged by its sum over the picture in the same way; light of S that is missing is "
        "named, too, where the stats name as large a share of the light as lost by the method's own fault.");
}

}  // namespace

std::vector<std::string> bench_definitions(const BenchResult& result) {
    std::vector<std::string> texts = {
        "Over the pixels that a run and the reference cover by the same share of their samples, all frames "
        "and three "
        "channels, as shares of the reference's mean there (infinite where it has no light and a run has). "
        "“Inside”: pixels whose eight neighbours show the "
        "same "
        "surface, turned by 20° at most; at edges between objects a footprint is that of one of them. 4×4: "
        "RMSE of "
        "means over blocks. Energy: luminance of the layer over the whole picture, by its coverage, less the "
        "reference's.",
        "HDR-FLIP: of R, G, B, mean over pixels and frames, exposures " +
            formatted("%.2f", result.exposures.start) + " to " + formatted("%.2f", result.exposures.stop) +
            " stops in " + std::to_string(result.exposures.count) +
            " steps, from the first, middle and last frame of the reference.",
        "Flicker: mean over pixels and frames of (D(t) − (D(t−1) + D(t+1)) / 2)², D the difference of "
        "luminance, over the squared mean of the run's own; none without three consecutive frames."};
    const ReferenceNoise& noise = result.reference->noise;
    if (noise.rmse) {
        texts.push_back(
            "The reference's own noise is " + percent(*noise.rmse) + " % (RMSE of luminance) and about " +
            percent(*noise.l1) +
            " % (L1, were it normally distributed). Its mean variance, that of "
            "sample 0 over the number of "
            "samples, is taken off the squared errors of RMSE; 1/16 of it off those of 4×4 blocks and 3/2 of "
            "it off flicker, as if "
            "pixels and frames were independent. L1 and FLIP are with the noise, so that an L1 below it "
            "cannot be seen.");
    } else {
        texts.push_back("The reference's own noise in this layer is not known; nothing is taken off.");
    }
    return texts;
}

std::string bench_html(const BenchResult& result) {
    HtmlPage page("Bench of " + (!result.timeline.empty() ? result.timeline
                                 : result.claims.empty()  ? "hard cases"
                                                          : "claims"));
    if (result.reference) {
        const ReferenceResult& r = *result.reference;
        page.paragraph("Frames " + result.frames + ", " + std::to_string(result.width) + " × " +
                       std::to_string(result.height) + ", " + std::to_string(result.samples) +
                       " samples a pixel; layer " + (result.layer.empty() ? "R, G, B" : result.layer) +
                       ". The reference took " + formatted("%.1f", r.wall_s) + " s (" +
                       formatted("%.1f", r.cpu_s) + " CPU s) a frame to a standard error of " +
                       percent(r.standard_error) + " %.");
        for (const RungResult& rung : result.rungs)
            if (!rung.failure.empty()) page.verdict(rung.rung.name + ": " + rung.failure, Tone::bad);
        page.heading("Error over time");
        add_plot(page, result, "Relative L1 inside surfaces", Judged::layer, Clock::wall, kL1Inside);
        add_plot(page, result, "Relative RMSE, less the reference's noise", Judged::layer, Clock::wall,
                 kRmse);
        add_plot(page, result, "Relative L1 inside surfaces", Judged::layer, Clock::cpu, kL1Inside);
        if (r.noise.rmse)
            page.paragraph(
                "The reference's line is its own noise at the time it took for the layer and scattered light "
                "together, and as 1 / √time before: where a method's line lies below it, brute force of the "
                "same time would be worse.");
        add_scattered(page, result);
        add_times(page, result);
        add_errors(page, result);
        add_maps(page, result);
        add_passes(page, result);
        add_notes(page, result);
    }
    if (!result.claims.empty()) add_claims(page, result.claims);
    if (!result.hard_cases.empty()) add_hard_cases(page, result);
    page.heading("Made with");
    std::vector<std::vector<Cell>> rows;
    for (const auto& [name, text] : result.provenance) rows.push_back({{name}, {text}});
    page.table({"what", "which"}, rows);
    page.data(bench_json(result));
    return page.html();
}

}  // namespace dapple::judge
