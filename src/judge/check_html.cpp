#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "judge/check_report.h"
#include "judge/sequence_reader.h"
#include "report/canvas.h"
#include "report/heat_map.h"
#include "report/html_page.h"
#include "report/plot.h"

namespace dapple::judge {
namespace {

using report::Canvas;
using report::HtmlPage;
using report::short_number;

constexpr int kMostMapWidth = 960;  // pixels of the heat map
constexpr int kCropSide = 64;       // pixels of a picture around a place
constexpr int kZoom = 3;
constexpr std::size_t kMostPlaces = 6;
constexpr int kGap = 6;
constexpr int kTextSize = 16;

/// The sRGB code value of linear light (IEC 61966-2-1).
std::uint8_t code_of(double linear) {
    const double held = std::clamp(linear, 0.0, 1.0);
    const double value = held <= 0.0031308 ? 12.92 * held : 1.055 * std::pow(held, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * value));
}

/// A place to be shown: around a pixel of a frame.
struct Place {
    std::int64_t frame = 0;
    Pixel middle;
    std::string caption;
};

std::vector<Place> places_of(const CheckResult& result) {
    std::vector<Place> places;
    for (const Finding& finding : result.findings) {
        if (!finding.frame || finding.kind == FindingKind::missing || finding.kind == FindingKind::damaged ||
            places.size() == kMostPlaces) {
            continue;
        }
        const Box box = finding.region.value_or(Box{0, 0, result.width, result.height});
        places.push_back({*finding.frame, {box.x + box.width / 2, box.y + box.height / 2}, line_of(finding)});
    }
    if (result.flicker.worst_frame && places.size() < kMostPlaces) {
        places.push_back({*result.flicker.worst_frame, result.worst_pixel,
                          "the pixel that deviates most in time, (" + std::to_string(result.worst_pixel.x) +
                              ", " + std::to_string(result.worst_pixel.y) +
                              "), in the frame that flickers most, " +
                              std::to_string(*result.flicker.worst_frame)});
    }
    return places;
}

/// Draws the pixels around a place, each as a square. Linear light is scaled so that the clip's mean is a
/// mid-grey of 0.18.
void draw_crop(Canvas& canvas, int left, int top, const ReadFrame& frame, Pixel middle, double level) {
    const metrics::Picture& picture = *frame.picture;
    const int x0 = std::clamp(middle.x - kCropSide / 2, 0, std::max(picture.width - kCropSide, 0));
    const int y0 = std::clamp(middle.y - kCropSide / 2, 0, std::max(picture.height - kCropSide, 0));
    const double scale = level > 0 ? 0.18 / level : 1;
    for (int y = 0; y < kCropSide && y0 + y < picture.height; ++y) {
        for (int x = 0; x < kCropSide && x0 + x < picture.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(picture.width) +
                                  static_cast<std::size_t>(x0 + x);
            std::uint8_t code[3];
            for (std::size_t c = 0; c < 3; ++c) {
                const auto value = static_cast<double>(picture.rgb[c][i]);
                code[c] = frame.display_referred
                              ? static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)))
                              : code_of(value * scale);
            }
            canvas.fill(left + kZoom * x, top + kZoom * y, kZoom, kZoom, {code[0], code[1], code[2]});
        }
    }
}

/// The place in the frame and its neighbours, below it in the reference.
void add_place(HtmlPage& page, const CheckResult& result, const std::vector<Sequence>& sequences,
               const Place& place) {
    ReadOptions options;
    options.layer = result.options.layer;
    for (const FrameFigures& figures : result.frames) {
        if (std::abs(figures.frame - place.frame) <= 1) options.frames.push_back(figures.frame);
    }
    if (options.frames.empty()) return;
    const int cell = kCropSide * kZoom + kGap;
    Canvas canvas(static_cast<int>(options.frames.size()) * cell + kGap,
                  static_cast<int>(sequences.size()) * cell + kTextSize + 2 * kGap, {24, 24, 24});
    SequenceReader reader(sequences, options);
    int column = 0;
    for (std::vector<ReadFrame> step = reader.next(); !step.empty(); step = reader.next(), ++column) {
        const int left = kGap + column * cell;
        canvas.text(left, kGap, kTextSize, {230, 230, 230}, "frame " + std::to_string(step[0].frame));
        for (std::size_t row = 0; row < step.size(); ++row) {
            const int top = kTextSize + 2 * kGap + static_cast<int>(row) * cell;
            if (step[row].picture) {
                draw_crop(canvas, left, top, step[row], place.middle, result.level);
            } else {
                canvas.text(left, top, kTextSize, {230, 120, 120}, "none");
            }
        }
    }
    page.picture(canvas.width(), canvas.height(), canvas.rgb(),
                 place.caption + (sequences.size() > 1 ? " (below: the reference)" : ""));
}

void add_deviation(HtmlPage& page, const CheckResult& result) {
    if (result.deviation.empty() || result.flicker.mean <= 0) return;
    // The largest value of every cell, so that a single pixel stays in sight.
    const int step = (result.width + kMostMapWidth - 1) / kMostMapWidth;
    const int width = (result.width + step - 1) / step;
    const int height = (result.height + step - 1) / step;
    std::vector<float> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < result.height; ++y) {
        for (int x = 0; x < result.width; ++x) {
            float& value = values[static_cast<std::size_t>(y / step) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x / step)];
            value = std::max(
                value, result.deviation[static_cast<std::size_t>(y) * static_cast<std::size_t>(result.width) +
                                        static_cast<std::size_t>(x)]);
        }
    }
    for (float& value : values) value /= static_cast<float>(result.flicker.mean);
    // A few pixels would else leave the rest dark.
    std::vector<float> sorted = values;
    const auto nearly_all = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 999 / 1000);
    std::ranges::nth_element(sorted, nearly_all);
    const double full = std::max(static_cast<double>(*nearly_all), 1e-6);
    Canvas canvas(width, height + 40, {24, 24, 24});
    canvas.blit(0, 0, report::heat_map(values, full), width, height);
    report::draw_scale(canvas, 0, height, width, 40, full, "deviation / clip mean");
    page.picture(
        canvas.width(), canvas.height(), canvas.rgb(),
        "Temporal deviation: root of the mean square, over the frames, of a pixel's difference to the "
        "mean of its neighbours in time, over the clip's mean; the scale ends where 999 of 1000 pixels lie "
        "below");
}

using Value = std::function<std::optional<double>(const FrameFigures&)>;

report::Series series_of(const CheckResult& result, const std::string& name, const Value& value) {
    report::Series series;
    series.name = name;
    series.marks = result.frames.size() <= 100;
    for (const FrameFigures& figures : result.frames) {
        const double gap = std::numeric_limits<double>::quiet_NaN();
        series.points.emplace_back(static_cast<double>(figures.frame), value(figures).value_or(gap));
    }
    return series;
}

void add_plot(HtmlPage& page, const std::string& title, std::vector<report::Series> series,
              const std::optional<double>& limit = std::nullopt, bool log_y = false) {
    std::erase_if(series, [](const report::Series& one) {
        return std::ranges::none_of(one.points,
                                    [](const auto& point) { return std::isfinite(point.second); });
    });
    if (series.empty()) return;
    report::Plot plot;
    plot.title = title;
    plot.x_label = "frame";
    plot.log_y = log_y;
    plot.series = std::move(series);
    if (limit) plot.limits.emplace_back(*limit, "limit");
    page.plot(report::svg(plot));
}

void add_plots(HtmlPage& page, const CheckResult& result) {
    const CheckLimits& limits = result.options.limits;
    using Figure = std::optional<double>;
    add_plot(page, "Mean luminance",
             {series_of(result, "sequence",
                        [](const FrameFigures& f) { return f.readable ? Figure(f.mean) : std::nullopt; }),
              series_of(result, "reference", [](const FrameFigures& f) { return f.reference_mean; })});
    add_plot(page, "Flicker",
             {series_of(result, "flicker",
                        [&](const FrameFigures& f) -> Figure {
                            const auto frame = result.flicker.frames.find(f.frame);
                            if (frame == result.flicker.frames.end()) return std::nullopt;
                            return frame->second.flicker;
                        })},
             limits.max_flicker, true);
    add_plot(page, "Error over the reference's mean",
             {series_of(result, "RMSE",
                        [](const FrameFigures& f) {
                            return f.errors ? Figure(f.errors->relative_rmse()) : std::nullopt;
                        }),
              series_of(result, "L1",
                        [](const FrameFigures& f) {
                            return f.errors ? Figure(f.errors->relative_mae()) : std::nullopt;
                        }),
              series_of(result, "bias",
                        [](const FrameFigures& f) {
                            return f.errors ? Figure(f.errors->relative_bias()) : std::nullopt;
                        })},
             limits.max_error);
    add_plot(page, "FLIP",
             {series_of(result, "mean",
                        [](const FrameFigures& f) { return f.flip ? Figure(f.flip->mean) : std::nullopt; })},
             limits.max_flip);
    add_plot(page, "SSIM", {series_of(result, "SSIM", [](const FrameFigures& f) { return f.ssim; })},
             limits.min_ssim);
    add_plot(
        page, "PSNR [dB]",
        {series_of(result, "PSNR",
                   [](const FrameFigures& f) { return f.errors ? Figure(f.errors->psnr) : std::nullopt; })},
        limits.min_psnr);
}

void add_findings(HtmlPage& page, const CheckResult& result) {
    if (result.findings.empty()) return page.verdict("Clean: nothing found", HtmlPage::Tone::good);
    const std::size_t count = result.findings.size();
    page.verdict(std::to_string(count) + (count == 1 ? " finding" : " findings"), HtmlPage::Tone::bad);
    constexpr std::size_t kMostRows = 500;  // all are in the data
    std::vector<std::vector<HtmlPage::Cell>> rows;
    for (const Finding& finding : result.findings) {
        if (rows.size() == kMostRows) break;
        rows.push_back({{name_of(finding.kind), HtmlPage::Tone::bad}, {line_of(finding)}});
    }
    page.table({"kind", "what"}, rows);
    if (count > kMostRows) page.paragraph("The first " + std::to_string(kMostRows) + " are shown.");
}

void add_figures(HtmlPage& page, const CheckResult& result) {
    std::vector<std::vector<HtmlPage::Cell>> rows;
    rows.push_back({{"mean luminance [pixel value]"}, {short_number(result.flicker.mean)}, {""}});
    if (result.flicker.worst_frame) {
        const auto& worst = result.flicker.frames.at(*result.flicker.worst_frame);
        rows.push_back(
            {{"flicker [of mean squared]"},
             {short_number(result.flicker.flicker)},
             {short_number(worst.flicker) + " at frame " + std::to_string(*result.flicker.worst_frame)}});
    }
    for (const metrics::BandFlicker::Band& band : result.bands) {
        rows.push_back(
            {{"flicker energy, " + short_number(band.low_hz) + " to " + short_number(band.high_hz) +
              (result.fps > 0 ? " Hz" : " cycles a frame") + " [(pixel value)^2]"},
             {short_number(band.energy)},
             {""}});
    }
    if (result.split) {
        rows.push_back({{"static error [of mean R^2]"}, {short_number(result.split->static_error)}, {""}});
        rows.push_back(
            {{"flickering error [of mean R^2]"}, {short_number(result.split->flicker_energy)}, {""}});
    }
    for (const auto& [name, figure] : result.clip) {
        rows.push_back({{figure_name(name)},
                        {short_number(figure.mean)},
                        {short_number(figure.worst) + " at frame " + std::to_string(figure.worst_frame)}});
    }
    page.table({"figure", "clip", "worst frame"}, rows);
}

}  // namespace

std::string check_html(const CheckResult& result) {
    HtmlPage page("dapple check: " + result.options.sequence);
    page.paragraph(
        "Frames " + std::to_string(result.first) + " to " + std::to_string(result.last) + ", " +
        std::to_string(result.width) + " x " + std::to_string(result.height) + " pixels" +
        (result.options.reference.empty() ? std::string() : ", against " + result.options.reference) + ".");
    add_findings(page, result);
    for (const std::string& note : result.notes) page.paragraph("Note: " + note + ".");
    page.heading("Figures");
    add_figures(page, result);
    page.heading("Frame by frame");
    add_plots(page, result);
    page.heading("Where");
    add_deviation(page, result);
    std::vector<Sequence> sequences{find_sequence(result.options.sequence, result.options.pictures)};
    if (!result.options.reference.empty()) {
        sequences.push_back(find_sequence(result.options.reference, result.options.pictures));
        pair_singles(sequences[0], sequences[1]);
    }
    for (const Place& place : places_of(result)) add_place(page, result, sequences, place);
    page.paragraph("CPU seconds: " + short_number(result.metrics_cpu_s) + " for metrics, " +
                   short_number(result.decode_cpu_s) + " for decoding.");
    page.data(check_json(result));
    return page.html();
}

}  // namespace dapple::judge
