#include "render/settled_caustics.h"

#include <algorithm>
#include <cstdio>

#include "scene/schema.h"

namespace dapple::render {
namespace {

/// Share of the target from which on what no map changes stands in its way.
constexpr double kStands = 0.8;

std::string percent(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g %%", 100 * share);
    return text;
}

std::string name_of(scene::PhotonFootprint footprint) {
    const scene::Structure& caustics = *scene::frame_schema().find("caustics", "")->structure;
    return std::string(
        caustics.find("footprint", "photon_splatting")->choices[static_cast<std::size_t>(footprint)]);
}

}  // namespace

double SettledCaustics::error() const {
    double largest = 0;
    for (const PilotError& pilot : pilots) largest = std::max(largest, pilot.error);
    return largest;
}

void apply(const SettledCaustics& settled, scene::Caustics& caustics) {
    caustics.map.map_resolution = settled.map_resolution;
    caustics.photon_splatting.footprint = settled.footprint;
    caustics.denoise.passes = settled.denoise_passes;
}

std::string settings_text(const SettledCaustics& settled, const scene::Caustics& caustics) {
    std::string text = "map_resolution " + std::to_string(settled.map_resolution);
    if (caustics.method == "photon_splatting") text += ", footprint " + name_of(settled.footprint);
    if (caustics.denoise.filter != scene::DenoiseFilter::none)
        text += ", denoise.passes " + std::to_string(settled.denoise_passes);
    return text;
}

PlanLine plan_line(const SettledCaustics& settled, const scene::Caustics& caustics) {
    std::string errors, frames;
    double by_mesh = 0, by_pixels = 0;
    for (const PilotError& pilot : settled.pilots) {
        errors += (errors.empty() ? "" : ", ") + percent(pilot.error);
        frames += (frames.empty() ? "" : ", ") + std::to_string(pilot.frame);
        by_mesh = std::max(by_mesh, pilot.by_mesh);
        by_pixels = std::max(by_pixels, pilot.by_pixels);
    }
    std::string reason = settings_text(settled, caustics) + "; estimated " + errors + " in frame" +
                         (settled.pilots.size() > 1 ? "s " : " ") + frames + ", of it " + percent(by_mesh) +
                         " by the water's mesh, " + percent(by_pixels) + " by the size of pixels";
    if (settled.finest_tried == 0) {
        reason = settings_text(settled, caustics) + ": frames " + frames + " show no caustics to choose by";
    } else if (!settled.reached()) {
        const double stands = kStands * settled.target;
        reason += by_pixels > stands && by_pixels > by_mesh
                      ? ": no map comes closer; caustic_mesh or a larger picture would"
                  : by_mesh > stands ? ": no map comes closer; a finer mesh of the water would"
                                     : ": no map that is tried comes closer, up to " +
                                           std::to_string(settled.finest_tried) + " photons a side";
    }
    return {"target error: " + percent(settled.target), settled.reached() ? "yes" : "partly", reason};
}

std::vector<std::int64_t> pilot_frames(const scene::Clip& clip) {
    std::vector<std::int64_t> frames{
        clip.first_frame, clip.first_frame + (clip.last_frame - clip.first_frame) / 2, clip.last_frame};
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return frames;
}

}  // namespace dapple::render
