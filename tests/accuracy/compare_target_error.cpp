// What caustics.target_error chooses, and the errors that it tells beside true ones:
//   compare_target_error TIMELINE [METHOD [PATH=VALUE]...]
// The timeline's pilot frames at 240 x 135, by photon_splatting or caustic_mesh, for targets of 5, 2 and 1 %.
// True is the relative L1 of E against sliced_beams on water of three times as many cells each way: over the
// pixels that both cover and the channels, the sum of |difference| over that of sliced_beams', %. CPU-s are
// those of settling, and of the light and splats of the last pilot with the settings chosen. Overrides hold
// for both methods but for those that begin with "caustics.", which do for the maps.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/stats.h"
#include "gpu/device.h"
#include "ocean/lamp_mesh.h"
#include "ocean/water_surface.h"
#include "render/frame_renderer.h"
#include "render/settle.h"
#include "scene/area_light.h"
#include "timeline/timeline.h"

namespace {

using namespace dapple;

constexpr int kTrueMesh = 3;

const std::vector<float>& channel(const image::Image& image, const char* name) {
    const image::Channel* found = image.find(name);
    if (!found) throw Error(ExitCode::failure, std::string("no channel ") + name);
    return found->values;
}

double relative_l1(const image::Image& found, const image::Image& truth) {
    double apart = 0, sum = 0;
    for (const char* name : {"E.R", "E.G", "E.B"}) {
        const std::vector<float>&e = channel(found, name), &expected = channel(truth, name);
        for (std::size_t i = 0; i < e.size(); ++i) {
            if (!(channel(found, "covered")[i] > 0 && channel(truth, "covered")[i] > 0)) continue;
            apart += std::abs(static_cast<double>(e[i]) - static_cast<double>(expected[i]));
            sum += static_cast<double>(expected[i]);
        }
    }
    return apart / sum;
}

/// The water's mesh, finer than what is asked for; that of a file stays.
void refine(scene::FrameState& state) {
    if (!state.water || state.water->surface.type == scene::WaterSurfaceType::mesh_sequence) return;
    if (ocean::has_rings(*state.water)) {
        state.water->rings.cells *= kTrueMesh;
        return;
    }
    const scene::FrameState meshed = ocean::with_mesh_for_lamps(scene::with_emitter_parts(state));
    state.water->mesh_cells = kTrueMesh * ocean::grid_size(*meshed.water).cells_x;
}

void compare(const std::string& path, const std::string& method, const std::vector<std::string>& overrides) {
    gpu::Device device{{}};
    render::FrameRenderer renderer(device);
    const auto timeline = [&](const std::string& caustics, bool of_maps) {
        std::vector<std::string> settings{"clip.resolution=[240, 135]", "caustics={" + caustics + "}"};
        for (const std::string& setting : overrides)
            if (of_maps || !setting.starts_with("caustics.")) settings.push_back(setting);
        return timeline::Timeline::load(path, settings);
    };
    const auto exact = timeline("method: sliced_beams, path_counts: false", false);
    const std::vector<std::int64_t> frames = render::pilot_frames(exact.clip());
    std::vector<image::Image> truths;
    for (const std::int64_t frame : frames) {
        scene::FrameState state = exact.at(frame);
        refine(state);
        FrameStats stats;
        truths.push_back(renderer.render(state, stats).linear);
    }
    for (const char* target : {"5 %", "2 %", "1 %"}) {
        const auto asked = timeline("method: " + method + ", target_error: " + target, true);
        render::SettleRequest request;
        for (const std::int64_t frame : frames) request.pilots.push_back(asked.at(frame));
        request.choose_footprint = !asked.gives("caustics.footprint");
        const double start = cpu_seconds();
        const render::SettledCaustics settled = renderer.settle(request);
        const double settling = cpu_seconds() - start;
        std::string errors;
        double frame_s = 0;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            scene::FrameState state = request.pilots[i];
            render::apply(settled, state.caustics);
            FrameStats stats;
            const image::Image found = renderer.render(state, stats).linear;
            char text[64];
            std::snprintf(text, sizeof text, "  %5.2f /%5.2f", 100 * settled.pilots[i].error,
                          100 * relative_l1(found, truths[i]));
            errors += text;
            frame_s = 0;
            for (const PassTime& pass : stats.passes()) frame_s += pass.cpu_s;
        }
        const render::PlanLine line = render::plan_line(settled, request.pilots.front().caustics);
        std::printf("%-4s told / true, %%:%s | settling %.1f CPU-s, a frame %.1f | %s\n", target,
                    errors.c_str(), settling, frame_s, line.reason.c_str());
        std::fflush(stdout);
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "compare_target_error TIMELINE [METHOD [PATH=VALUE]...]\n");
        return 2;
    }
    try {
        const std::vector<std::string> arguments(argv + 1, argv + argc);
        compare(arguments[0], arguments.size() > 1 ? arguments[1] : "photon_splatting",
                {arguments.begin() + std::min<std::ptrdiff_t>(2, argc - 1), arguments.end()});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "compare_target_error: %s\n", error.what());
        return 1;
    }
    return 0;
}
