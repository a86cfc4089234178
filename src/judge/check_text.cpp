#include <array>
#include <cstdio>
#include <string>
#include <utility>

#include "base/error.h"
#include "judge/check_report.h"
#include "report/heat_map.h"

namespace dapple::judge {
namespace {

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string row(const std::string& name, const std::string& values) {
    constexpr std::size_t kColumn = 42;
    return name + std::string(name.size() < kColumn ? kColumn - name.size() : 1, ' ') + values + "\n";
}

/// Names of the figures of CheckResult::clip, in the order of the report. Absolute errors have the pixels'
/// own unit, whatever that is.
constexpr std::array<std::pair<const char*, const char*>, 18> kFigures{{
    {"relative_rmse", "RMSE [of reference's mean]"},
    {"relative_mae", "L1 [of reference's mean]"},
    {"relative_bias", "bias [of reference's mean]"},
    {"rmse", "RMSE [pixel value]"},
    {"block_rmse", "RMSE of 4x4 means [pixel value]"},
    {"mae", "L1 [pixel value]"},
    {"bias", "bias [pixel value]"},
    {"relative_mse", "relative MSE [1]"},
    {"psnr", "PSNR [dB]"},
    {"ssim", "SSIM [1]"},
    {"flip", "FLIP, mean [0 to 1]"},
    {"flip_weighted_median", "FLIP, weighted median [0 to 1]"},
    {"flip_largest", "FLIP, largest [0 to 1]"},
    {"difference_mae", "L1 of changes [pixel value]"},
    {"difference_rmse", "RMSE of changes [pixel value]"},
    {"delta_flip", "delta FLIP, mean [-1 to 1]"},
    {"delta_flip_absolute", "delta FLIP, absolute [0 to 1]"},
    {"warping_error", "warping error [(pixel value)^2]"},
}};

/// "0.0123, worst 0.05 at frame 7".
void add_figure(std::string& text, const CheckResult& result, const std::string& key) {
    const auto figure = result.clip.find(key);
    if (figure == result.clip.end()) return;
    const ClipFigure& clip = figure->second;
    text += row(figure_name(key), number(clip.mean) + (result.frames.size() > 1
                                                           ? ", worst " + number(clip.worst) + " at frame " +
                                                                 std::to_string(clip.worst_frame)
                                                           : ""));
}

void add_temporal(std::string& text, const CheckResult& result) {
    const metrics::ClipFlicker& flicker = result.flicker;
    text += row("mean luminance [pixel value]", number(flicker.mean));
    if (flicker.worst_frame) {
        text += row("flicker [of mean squared]", number(flicker.flicker) + ", worst " +
                                                     number(flicker.frames.at(*flicker.worst_frame).flicker) +
                                                     " at frame " + std::to_string(*flicker.worst_frame));
        text += row("worst pixel in time", "(" + std::to_string(result.worst_pixel.x) + ", " +
                                               std::to_string(result.worst_pixel.y) + "), deviation " +
                                               number(result.worst_deviation) + " of the mean");
    }
    if (flicker.frames.empty()) return;
    for (const metrics::BandFlicker::Band& band : result.bands) {
        const std::string unit = result.fps > 0 ? " Hz" : " /frame";
        text += row("energy, " + report::short_number(band.low_hz) + "-" +
                        report::short_number(band.high_hz) + unit + " [(pixel value)^2]",
                    number(band.energy));
    }
    if (result.split) {
        text += row("static error [of mean R^2]", number(result.split->static_error));
        text += row("flickering error [of mean R^2]", number(result.split->flicker_energy));
    }
}

void add_errors(std::string& text, const CheckResult& result) {
    for (const auto& [key, name] : kFigures) add_figure(text, result, key);
    if (result.flip_kind != FlipKind::none)
        text += row("FLIP's kind", result.flip_kind == FlipKind::hdr ? "HDR" : "LDR");
    if (result.flip_kind == FlipKind::hdr && result.exposures) {
        text += row("FLIP's exposures", number(result.exposures->start) + " to " +
                                            number(result.exposures->stop) + " stops, " +
                                            std::to_string(result.exposures->count));
    }
    const FrameFigures* worst = nullptr;
    for (const FrameFigures& figures : result.frames) {
        if (figures.errors && (worst == nullptr || figures.errors->largest > worst->errors->largest)) {
            worst = &figures;
        }
    }
    if (worst != nullptr && worst->errors->largest > 0) {
        const auto width = static_cast<std::size_t>(result.width);
        text += row("largest error [pixel value]", number(worst->errors->largest) + " at (" +
                                                       std::to_string(worst->errors->largest_pixel % width) +
                                                       ", " +
                                                       std::to_string(worst->errors->largest_pixel / width) +
                                                       ") of frame " + std::to_string(worst->frame));
    }
}

}  // namespace

std::string figure_name(const std::string& key) {
    for (const auto& [known, name] : kFigures)
        if (key == known) return name;
    return key;
}

std::string line_of(const Finding& finding) {
    std::string text;
    if (finding.frame) {
        text = finding.last_frame
                   ? "frames " + std::to_string(*finding.frame) + " to " + std::to_string(*finding.last_frame)
                   : "frame " + std::to_string(*finding.frame);
    } else {
        text = "clip";
    }
    text += std::string(" (") + name_of(finding.kind);
    if (finding.region) {
        const Box& box = *finding.region;
        text += ", (" + std::to_string(box.x) + ", " + std::to_string(box.y) + ") to (" +
                std::to_string(box.x + box.width - 1) + ", " + std::to_string(box.y + box.height - 1) + ")";
    }
    return clipped(text + "): " + finding.text);
}

std::string check_text(const CheckResult& result) {
    std::string text;
    for (const Finding& finding : result.findings) text += line_of(finding) + "\n";
    for (const std::string& note : result.notes) text += "note: " + note + "\n";
    std::size_t readable = 0;
    for (const FrameFigures& figures : result.frames) readable += figures.readable ? 1 : 0;
    text += row("frames", std::to_string(result.first) + " to " + std::to_string(result.last) + ", " +
                              std::to_string(readable) + " of " + std::to_string(result.frames.size()) +
                              " readable, " + std::to_string(result.width) + " x " +
                              std::to_string(result.height));
    add_temporal(text, result);
    add_errors(text, result);
    text += row("time", number(result.wall_s) + " s; CPU " + number(result.metrics_cpu_s) +
                            " s for metrics, " + number(result.decode_cpu_s) + " s for decoding; " +
                            std::to_string(result.peak_memory >> 20) + " MiB");
    text += result.findings.empty() ? "clean: nothing found\n"
                                    : std::to_string(result.findings.size()) +
                                          (result.findings.size() == 1 ? " finding\n" : " findings\n");
    return text;
}

}  // namespace dapple::judge
