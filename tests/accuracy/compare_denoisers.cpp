// What the filters over E buy, and what smaller buffers of it cost: a frame of the pool by photon_splatting
// with few photons against sliced_beams, which finds E without noise:
//   compare_denoisers [TIMELINE [FRAME [PATH=VALUE]...]]
// By default frame 24 of sequences/pool.yaml at 480 x 270, one camera path a pixel, 256 photons a side, first
// points a pixel wide, then tents over their neighbours. Overrides hold for both methods but for those that
// begin with "caustics.", which hold for the splats. Over the pixels that both cover, mean of the channels,
// %:
//   L1      sum of |difference| of E over the sum of sliced_beams';
//   bright  the same of pixels where that has more than twice its mean, dark: less than half;
//   detail  the contrast of neighbouring pixels that is left: sum of |E(x + 1) - E(x)| over sliced_beams';
//   mean    of E over that of sliced_beams, less 1;
//   power   told by the filter, after less before.
// CPU-ms are those of the filter, and of all passes that E takes: light, splats, buffer, filter.
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
#include "source_dir.h"
#include "timeline/timeline.h"

namespace {

using namespace dapple;

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
    double milliseconds(const char* pass) const {
        double sum = 0;
        for (const PassTime& time : stats.passes())
            if (time.name == pass) sum += 1e3 * time.cpu_s;
        return sum;
    }
    double milliseconds() const {
        double sum = 0;
        for (const PassTime& time : stats.passes()) sum += 1e3 * time.cpu_s;
        return sum;
    }
};

struct Setting {
    const char* name;
    const char* caustics;
};

constexpr Setting kSettings[] = {
    {"as found", ""},
    {"half scale", "buffer_scale: half"},
    {"quarter scale", "buffer_scale: quarter"},
    {"fixed, 1 pass", "denoise: {filter: fixed}"},
    {"fixed, 10 passes", "denoise: {filter: fixed, passes: 10}"},
    {"adaptive, 1 pass", "denoise: {filter: adaptive}"},
    {"adaptive 0.144, 1 pass", "denoise: {filter: adaptive, threshold: 0.144}"},
    {"adaptive, 4 passes", "denoise: {filter: adaptive, passes: 4}"},
    {"adaptive, half scale", "buffer_scale: half, denoise: {filter: adaptive}"},
    {"paper: fixed, 1 pass", "denoise: {filter: fixed, paper_faithful: true}"},
    {"paper: fixed, 10 passes", "denoise: {filter: fixed, passes: 10, paper_faithful: true}"},
    {"paper: adaptive, 1 pass", "denoise: {filter: adaptive, paper_faithful: true}"},
    {"paper: adaptive, 4 passes", "denoise: {filter: adaptive, passes: 4, paper_faithful: true}"},
};

/// Passes that E does not take. Camera paths count: smaller buffers have their own.
constexpr const char* kOtherPasses[] = {"scene", "ray scene", "shading", "film"};

/// Sums over pixels of a kind.
struct Difference {
    double l1 = 0, sum = 0, found_sum = 0;
    void add(float found, float expected) {
        found_sum += static_cast<double>(found);
        l1 += static_cast<double>(std::abs(found - expected));
        sum += static_cast<double>(expected);
    }
    double percent() const { return 100 * l1 / sum; }
    double mean() const { return found_sum / sum; }
};

void print(const char* name, const Rendered& found, const Rendered& expected) {
    const std::vector<float>& ours = found.channel("covered");
    const std::vector<float>& theirs = expected.channel("covered");
    double mean = 0, count = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        if (!(ours[i] > 0 && theirs[i] > 0)) continue;
        mean += static_cast<double>(expected.irradiance(i));
        ++count;
    }
    const auto even = static_cast<float>(mean / count);
    Difference all, bright, dark;
    double contrast = 0, expected_contrast = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        if (!(ours[i] > 0 && theirs[i] > 0)) continue;
        const float e = found.irradiance(i), truth = expected.irradiance(i);
        all.add(e, truth);
        if (truth > 2 * even) bright.add(e, truth);
        if (truth < 0.5f * even) dark.add(e, truth);
        const bool ends = (i + 1) % static_cast<std::size_t>(found.image.width) == 0;
        if (ends || !(ours[i + 1] > 0 && theirs[i + 1] > 0)) continue;
        contrast += static_cast<double>(std::abs(found.irradiance(i + 1) - e));
        expected_contrast += static_cast<double>(std::abs(expected.irradiance(i + 1) - truth));
    }
    const double before = found.stats.counted("power before denoising, W");
    const double change = before > 0 ? found.stats.counted("power after denoising, W") / before - 1 : 0;
    double other = 0;
    for (const char* pass : kOtherPasses) other += found.milliseconds(pass);
    std::printf("%-26s | %7.2f %7.2f %7.2f %7.1f %+8.3f %+9.4f | %7.1f %7.1f\n", name, all.percent(),
                bright.percent(), dark.percent(), 100 * contrast / expected_contrast, 100 * (all.mean() - 1),
                100 * change, found.milliseconds("denoise"), found.milliseconds() - other);
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
    const Rendered expected = rendered({"clip.samples=1", "clip.resolution=[480, 270]",
                                        "caustics={method: sliced_beams, path_counts: false}"},
                                       false);
    for (const char* footprint : {"point", "tent"}) {
        std::printf("%-26s | %7s %7s %7s %7s %8s %9s | %7s %7s\n", footprint, "L1", "bright", "dark",
                    "detail", "mean", "power", "filter", "E");
        for (const Setting& setting : kSettings) {
            const std::string caustics =
                std::string("caustics={method: photon_splatting, map_resolution: 256, footprint: ") +
                footprint + (*setting.caustics ? ", " : "") + setting.caustics + "}";
            print(setting.name, rendered({"clip.samples=1", "clip.resolution=[480, 270]", caustics}, true),
                  expected);
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::vector<std::string> arguments(argv + 1, argv + argc);
        const std::string timeline =
            arguments.empty() ? std::string(DAPPLE_SOURCE_DIR) + "/sequences/pool.yaml" : arguments[0];
        const int frame = arguments.size() > 1 ? std::atoi(arguments[1].c_str()) : 24;
        compare(timeline, frame,
                {arguments.begin() + std::min<std::ptrdiff_t>(2, argc - 1), arguments.end()});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "compare_denoisers: %s\n", error.what());
        return 1;
    }
    return 0;
}
