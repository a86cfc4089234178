// What cascades of caustic maps buy: a frame of columns and a far wall by photon_splatting, whose N cascades
// together are 15, 30 and 60 m wide (Kougianos and Moustakas 2021, figures 8 and 9), against sliced_beams:
//   compare_cascades [TIMELINE [FRAME [PATH=VALUE]...]]
// By default frame 1 of sequences/cascades.yaml at 192 x 108, one camera path a pixel, 256 photons along each
// side of a map. N = 1 is one map of the whole width; "one map" has the photons everywhere as wide apart as
// the innermost cascade has. Overrides hold for both methods but for those that begin with "caustics.", which
// hold for the splats. Mean of the channels over the pixels that both cover, %: sum of |difference| of E over
// the sum of sliced_beams', of receivers less than 7.5 m before the camera (near) and more than 15 m (far);
// dark: share of far pixels without light.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "base/error.h"
#include "gpu/device.h"
#include "render/frame_renderer.h"
#include "timeline/timeline.h"

namespace {

using namespace dapple;

constexpr float kNear = 7.5f, kFar = 15;           // m before the camera
constexpr int kResolution = 256, kLargest = 2048;  // photons a side, of a cascade and of one map

struct Rendered {
    image::Image image;
    FrameStats stats;
    const std::vector<float>& channel(const char* name) const {
        const image::Channel* found = image.find(name);
        if (!found) throw Error(ExitCode::failure, std::string("no channel ") + name);
        return found->values;
    }
    float irradiance(std::size_t i) const {
        return (channel("E.R")[i] + channel("E.G")[i] + channel("E.B")[i]) / 3;
    }
    /// CPU-s of what the light side does, and of drawing its splats.
    double light_seconds() const {
        double sum = 0;
        for (const PassTime& time : stats.passes())
            for (const char* pass : {"caustic map", "refraction", "light shadows", "photon tracing",
                                     "photon footprints", "splatting"})
                if (time.name == pass) sum += time.cpu_s;
        return sum;
    }
};

struct Difference {
    double l1 = 0, sum = 0, pixels = 0, dark = 0;
    void add(float found, float expected) {
        l1 += static_cast<double>(std::abs(found - expected));
        sum += static_cast<double>(expected);
        ++pixels;
        dark += found > 0 ? 0 : 1;
    }
};

void print(double width, const std::string& name, const Rendered& found, const Rendered& expected) {
    const std::vector<float>& covered = found.channel("covered");
    const std::vector<float>& depth = expected.channel("Z");
    Difference near, far;
    for (std::size_t i = 0; i < depth.size(); ++i) {
        if (!(covered[i] > 0 && expected.channel("covered")[i] > 0)) continue;
        if (depth[i] < kNear) near.add(found.irradiance(i), expected.irradiance(i));
        if (depth[i] > kFar) far.add(found.irradiance(i), expected.irradiance(i));
    }
    std::printf("%5g m  %-14s | %7.2f %7.2f %6.1f | %10.0f %8.2f\n", width, name.c_str(),
                100 * near.l1 / near.sum, 100 * far.l1 / far.sum, 100 * far.dark / far.pixels,
                found.stats.counted("photons"), found.light_seconds());
    std::fflush(stdout);
}

void compare(const std::string& timeline, int frame, const std::vector<std::string>& overrides) {
    gpu::Device device{{}};
    render::FrameRenderer renderer(device);
    const auto rendered = [&](std::vector<std::string> settings, bool splats) {
        for (const std::string& setting : overrides)
            if (splats || !setting.starts_with("caustics.")) settings.push_back(setting);
        Rendered result;
        const scene::FrameState state = timeline::Timeline::load(timeline, settings).at(frame);
        result.image = renderer.render(state, result.stats).linear;
        return result;
    };
    const auto splatted = [&](double width, int cascades, int resolution) {
        std::vector<std::string> settings{"clip.samples=1", "clip.resolution=[192, 108]"};
        settings.push_back("caustics={method: photon_splatting, cascades: " + std::to_string(cascades) +
                           ", inner_size: " + std::to_string(width / std::pow(2, cascades - 1)) +
                           " m, map_resolution: " + std::to_string(resolution) + "}");
        return rendered(std::move(settings), true);
    };
    const Rendered expected = rendered({"clip.samples=1", "clip.resolution=[192, 108]",
                                        "caustics={method: sliced_beams, path_counts: false}"},
                                       false);
    splatted(15, 1, kResolution);  // the first frame compiles what runs on the device
    std::printf("%7s  %-14s | %7s %7s %6s | %10s %8s\n", "range", "", "near", "far", "dark", "photons",
                "CPU-s");
    for (const double width : {15.0, 30.0, 60.0})
        for (int cascades = 1; cascades <= 4; ++cascades) {
            print(width, "N = " + std::to_string(cascades), splatted(width, cascades, kResolution), expected);
            const int fine = kResolution << (cascades - 1);
            if (cascades > 1 && fine <= kLargest)
                print(width, "one map, " + std::to_string(fine), splatted(width, 1, fine), expected);
        }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::vector<std::string> arguments(argv + 1, argv + argc);
        const std::string timeline =
            arguments.empty() ? std::string(DAPPLE_SOURCE_DIR) + "/sequences/cascades.yaml" : arguments[0];
        const int frame = arguments.size() > 1 ? std::atoi(arguments[1].c_str()) : 1;
        compare(timeline, frame,
                {arguments.begin() + std::min<std::ptrdiff_t>(2, argc - 1), arguments.end()});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "compare_cascades: %s\n", error.what());
        return 1;
    }
    return 0;
}
