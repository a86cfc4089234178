// Writes a page with one of everything to standard output, to be looked at and opened in a browser.
#include <cmath>
#include <cstdio>

#include "report/heat_map.h"
#include "report/html_page.h"
#include "report/plot.h"

using namespace dapple::report;

int main() {
    HtmlPage page("A page with one of everything");
    page.verdict("2 of 120 frames exceed the limit of 0.02: 17, 42", HtmlPage::Tone::bad);
    page.verdict("no frame is missing", HtmlPage::Tone::good);
    page.verdict("the reference was not given", HtmlPage::Tone::plain);
    page.paragraph(
        "Flicker of a frame is the mean over pixels of the squared second difference of luminance in time, "
        "divided by the squared mean of the clip.");

    page.heading("Flicker over the clip");
    Plot flicker{.title = "Flicker of each frame",
                 .x_label = "frame",
                 .y_label = "flicker",
                 .limits = {{0.02, "limit 0.02"}}};
    Plot logarithmic{.title = "Relative RMSE over time",
                     .x_label = "CPU time a frame [s]",
                     .y_label = "relative RMSE",
                     .log_x = true,
                     .log_y = true};
    for (int k = 0; k < 3; ++k) {
        Series line{.name = k == 0   ? "sliced_beams"
                            : k == 1 ? "photon_splatting"
                                     : "reference",
                    .points = {}};
        for (int i = 1; i <= 120; ++i)
            line.points.emplace_back(
                i, 0.004 * (k + 1) + 0.002 * std::sin(0.2 * i * (k + 1)) + (i == 42 && k == 1 ? 0.02 : 0));
        flicker.series.push_back(line);
        Series errors{.name = line.name, .points = {}, .line = true, .marks = true};
        for (int i = 0; i < 6; ++i)
            errors.points.emplace_back(0.1 * std::pow(2.5, i + k), 0.4 * std::pow(0.5, i) / (k + 1));
        logarithmic.series.push_back(errors);
    }
    page.plot(svg(flicker));
    page.plot(svg(logarithmic));
    page.plot(svg({.title = "Nothing", .x_label = "", .y_label = ""}));

    page.heading("Worst frames");
    page.table({"frame", "flicker", "share of pixels that jump", "what"},
               {{{"17"}, {"0.0231", HtmlPage::Tone::bad}, {"0.4 %"}, {"a flash"}},
                {{"42"}, {"0.0292", HtmlPage::Tone::bad}, {"12.1 %"}, {"a popped region"}},
                {{"43"}, {"0.0102", HtmlPage::Tone::good}, {"0 %"}, {"none"}}});
    std::vector<float> values;
    for (int y = 0; y < 90; ++y) {
        for (int x = 0; x < 160; ++x)
            values.push_back(static_cast<float>(std::abs(std::sin(x * 0.1) * std::cos(y * 0.13))));
    }
    page.picture(160, 90, heat_map(values, 1), "difference of frame 42, full at 1");
    Canvas canvas(420, 160, {24, 24, 28});
    canvas.text(10, 8, 18, {255, 255, 255}, "Text 18 px: sliced_beams, frame 0042, t = 1.750 s");
    canvas.text(10, 34, 12, {200, 200, 200}, "Text 12 px: photon_splatting | Größe, Öl, Åse, 1.25e-05");
    canvas.text(10, 56, 9, {200, 200, 200}, "Text 9 px: relative RMSE 0.0123");
    canvas.line(10, 84, 400, 100, {255, 160, 0});
    canvas.line(10, 100, 400, 84, {90, 170, 255}, 2.5);
    draw_scale(canvas, 10, 112, 400, 36, 0.25, "|A - B| / clip mean");
    page.picture(420, 160, canvas.rgb(), "a canvas");
    page.data("{\"flicker\": [1, 2, 3], \"name\": \"</script>\"}");
    std::fputs(page.html().c_str(), stdout);
}
