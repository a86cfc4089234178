// What each footprint of photon_splatting makes of one sinusoid (closed_form/sinusoid.h), before, at and
// behind its focus: relative L1 error of E for 512, 1024 and 2048 photons along 3 m, a third as many across,
// against 500 pixels a metre. Beside it the time of what hangs on footprints (splats made and drawn). Last
// sliced_beams, which is exact but for its mesh of 2 mm. With a star: after the mean has been made the exact
// one.
#include <cstdio>
#include <exception>
#include <string>

#include "closed_form/sinusoid.h"
#include "gpu/device.h"
#include "render/frame_renderer.h"

namespace {

using namespace dapple;
using Name = scene::PhotonFootprint;

constexpr int kPixels = 500, kRows = 16;

struct Row {
    const char* label;
    Name name;
    double scale;
    bool paper;
    bool matched = false;  // in mean: Kougianos and Moustakas dim light by ramps of their own
};

const Row kTable[] = {
    {"tent", Name::tent, 1, false},
    {"fixed", Name::fixed, 1, false},
    {"fixed, scale 2", Name::fixed, 2, false},
    {"photon_differential", Name::photon_differential, 1, false},
    {"photon_difference", Name::photon_difference, 1, false},
    {"photon_difference, paper", Name::photon_difference, 1, true},
    {"photon_differential, paper*", Name::photon_differential, 1, true, true},
    {"fixed, paper*", Name::fixed, 1, true, true},
    {"point", Name::point, 1, false},
    {"point, paper (Gruen)", Name::point, 1, true},
};

struct Measured {
    double error, seconds_a_photon;
};

Measured measure(render::FrameRenderer& renderer, scene::FrameState& state, double depth, bool matched) {
    FrameStats stats;
    const render::RenderedFrame frame = renderer.render(state, stats);
    double time = 0;
    for (const PassTime& pass : stats.passes())
        if (pass.name == "photon footprints" || pass.name == "splatting") time += pass.wall_s;
    return {test::sinusoid_error(frame.linear.find("E.R")->values, depth, kPixels, matched),
            time / stats.counted("photons")};
}

void compare(render::FrameRenderer& renderer, double focal_depths) {
    const double depth = focal_depths * test::kSinusoidFocus;
    scene::FrameState state = test::sinusoid_pool(depth, kPixels, kRows);
    std::printf("\nfloor at %.2f m, %.1f focal depths\n%-28s %18s %18s %18s\n", depth, focal_depths, "",
                "512", "1024", "2048");
    state.caustics.method = "photon_splatting";
    for (const Row& row : kTable) {
        std::printf("%-28s", row.label);
        for (const int resolution : {512, 1024, 2048}) {
            state.caustics.map.map_resolution = resolution;
            state.caustics.map.paper_faithful = row.paper;
            state.caustics.photon_splatting = {row.name, row.scale};
            const Measured measured = measure(renderer, state, depth, row.matched);
            std::printf("  %7.3f %% %4.0f ms", 100 * measured.error, 1e9 * measured.seconds_a_photon);
            std::fflush(stdout);
        }
        std::printf("\n");
    }
    state.caustics.method = "sliced_beams";
    std::printf("%-28s  %7.3f %%\n", "sliced_beams", 100 * measure(renderer, state, depth, false).error);
}

}  // namespace

int main() try {
    gpu::Device device({});
    render::FrameRenderer renderer(device);
    for (const double focal_depths : {0.5, 1.0, 2.0}) compare(renderer, focal_depths);
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
