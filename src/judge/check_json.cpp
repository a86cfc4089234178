#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "judge/check_report.h"
#include "run/json_number.h"

namespace dapple::judge {
namespace {

using run::json_number;
using Json = nlohmann::ordered_json;

Json to_json(const Box& box) {
    return {{"x", box.x}, {"y", box.y}, {"width", box.width}, {"height", box.height}};
}

Json to_json(const Finding& finding) {
    Json json = {{"kind", name_of(finding.kind)}, {"frame", nullptr}, {"text", line_of(finding)}};
    if (finding.frame) json["frame"] = *finding.frame;
    if (finding.last_frame) json["last_frame"] = *finding.last_frame;
    if (finding.region) json["region"] = to_json(*finding.region);
    return json;
}

Json pixel_json(std::size_t index, int width) {
    const auto columns = static_cast<std::size_t>(width);
    return {index % columns, index / columns};
}

void add_errors(Json& json, const FrameFigures& figures, int width) {
    if (!figures.errors) return;
    const metrics::Errors& errors = *figures.errors;
    json["reference_mean"] = json_number(*figures.reference_mean);
    json["errors"] = {{"mean", json_number(errors.mean)},
                      {"bias", json_number(errors.bias)},
                      {"mae", json_number(errors.mae)},
                      {"rmse", json_number(errors.rmse)},
                      {"block_rmse", json_number(errors.block_rmse)},
                      {"relative_bias", json_number(errors.relative_bias())},
                      {"relative_mae", json_number(errors.relative_mae())},
                      {"relative_rmse", json_number(errors.relative_rmse())},
                      {"relative_mse", json_number(errors.relative_mse)},
                      {"largest", json_number(errors.largest)},
                      {"largest_pixel", pixel_json(errors.largest_pixel, width)}};
    json["psnr"] = json_number(errors.psnr);
    if (figures.ssim) json["ssim"] = json_number(*figures.ssim);
    if (figures.flip) {
        json["flip"] = {{"mean", json_number(figures.flip->mean)},
                        {"weighted_median", json_number(figures.flip->weighted_median)},
                        {"largest", json_number(figures.flip->largest)},
                        {"largest_pixel", {figures.flip->worst.x, figures.flip->worst.y}}};
    }
    if (figures.difference) {
        json["difference"] = {{"mae", json_number(figures.difference->mae)},
                              {"rmse", json_number(figures.difference->rmse)}};
    }
    if (figures.delta_flip) {
        json["delta_flip"] = {{"mean", json_number(figures.delta_flip->mean)},
                              {"mean_absolute", json_number(figures.delta_flip->mean_absolute)}};
    }
    if (figures.shift) json["shift"] = {json_number(figures.shift->dx), json_number(figures.shift->dy)};
}

Json to_json(const FrameFigures& figures, const CheckResult& result) {
    Json json = {{"frame", figures.frame}, {"file", figures.path}, {"readable", figures.readable}};
    if (!figures.fault.empty()) json["fault"] = figures.fault;
    if (!figures.readable) return json;
    json["mean"] = json_number(figures.mean);
    json["not_finite"] = figures.not_finite;
    if (figures.temporal) {
        const metrics::ClipFlicker::Frame& frame = result.flicker.frames.at(figures.frame);
        json["flicker"] = json_number(frame.flicker);
        json["jump_share"] = json_number(frame.jump_share);
        json["change_before"] = json_number(figures.temporal->change_before);
        json["change_after"] = json_number(figures.temporal->change_after);
    }
    add_errors(json, figures, result.width);
    if (figures.warping) {
        json["warping"] = {{"mean_square", json_number(figures.warping->mean_square)},
                           {"visible_share", json_number(figures.warping->visible_share)}};
    }
    return json;
}

const char* name_of_flip(FlipKind kind) {
    switch (kind) {
        case FlipKind::ldr:
            return "ldr";
        case FlipKind::hdr:
            return "hdr";
        case FlipKind::automatic:
        case FlipKind::none:
            break;
    }
    return "none";
}

/// The clip's figures; those that the frames have too carry the same names, as means over the frames.
Json clip_json(const CheckResult& result) {
    const metrics::ClipFlicker& flicker = result.flicker;
    Json json = {{"mean", json_number(flicker.mean)}, {"flicker", json_number(flicker.flicker)}};
    json["worst_flicker_frame"] = nullptr;
    if (flicker.worst_frame) {
        json["worst_flicker_frame"] = *flicker.worst_frame;
        json["worst_pixel"] = {{"x", result.worst_pixel.x},
                               {"y", result.worst_pixel.y},
                               {"deviation", json_number(result.worst_deviation)}};
    }
    json["bands"] = Json::array();
    for (const metrics::BandFlicker::Band& band : result.bands) {
        json["bands"].push_back({{result.fps > 0 ? "low_hz" : "low_per_frame", json_number(band.low_hz)},
                                 {result.fps > 0 ? "high_hz" : "high_per_frame", json_number(band.high_hz)},
                                 {"energy", json_number(band.energy)}});
    }
    if (result.split) {
        json["static_error"] = json_number(result.split->static_error);
        json["flicker_energy"] = json_number(result.split->flicker_energy);
    }
    for (const auto& [name, figure] : result.clip) {
        json[name] = json_number(figure.mean);
        json["worst"][name] = {{"value", json_number(figure.worst)}, {"frame", figure.worst_frame}};
    }
    if (result.flip_kind != FlipKind::none) {
        json["flip_kind"] = name_of_flip(result.flip_kind);
        json["pixels_per_degree"] = result.options.pixels_per_degree;
    }
    if (result.exposures) {
        json["exposures"] = {{"start", json_number(result.exposures->start)},
                             {"stop", json_number(result.exposures->stop)},
                             {"count", result.exposures->count}};
    }
    return json;
}

}  // namespace

std::string check_json(const CheckResult& result) {
    Json json = {{"v", 1},
                 {"clean", result.findings.empty()},
                 {"sequence", result.options.sequence},
                 {"reference", nullptr},
                 {"layer", result.options.layer},
                 {"frame_range", {result.first, result.last}},
                 {"width", result.width},
                 {"height", result.height},
                 {"display_referred", result.display_referred},
                 {"peak", result.options.peak}};
    if (!result.options.reference.empty()) json["reference"] = result.options.reference;
    json["findings"] = Json::array();
    for (const Finding& finding : result.findings) json["findings"].push_back(to_json(finding));
    json["notes"] = result.notes;
    json["clip"] = clip_json(result);
    json["frames"] = Json::array();
    for (const FrameFigures& figures : result.frames) json["frames"].push_back(to_json(figures, result));
    json["seconds"] = {{"wall", result.wall_s},
                       {"cpu_metrics", result.metrics_cpu_s},
                       {"cpu_decoding", result.decode_cpu_s}};
    json["peak_memory"] = result.peak_memory;
    // Names come from files in any encoding; what is no UTF-8 is replaced, never thrown.
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dapple::judge
