// Flicker of the light that media scatter against a reference, as compare_flicker.cpp has it for E:
//   scatter_flicker TIMELINE FOLDER FIRST LAST STANDARD_ERROR SAMPLES [PATH=VALUE]...
// S is what pixels of 96 x 54 receive along the camera's first branch; the second, of what the surface
// mirrors, costs the reference many times as much as all the rest. Frames of the reference, by one camera
// path a pixel that stands for all of it and eight million rays at most, are kept in FOLDER and used again.
// `sliced_beams` is asked by SAMPLES camera paths a pixel and with the overrides of the timeline that are
// given.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "accuracy/flicker_series.h"
#include "accuracy/scatter_pictures.h"
#include "methods/sliced_beams/sliced_beams.h"
#include "render/frame_scene_builder.h"
#include "timeline/timeline.h"

namespace {

using namespace dapple;

constexpr const char* kResolution = "clip.resolution=[96, 54]";
constexpr std::size_t kWidth = 96, kBands = 12;
constexpr int kMostRays = 8;  ///< millions a light

struct Arguments {
    std::string timeline, folder;
    int first = 1, last = 1;
    std::string standard_error, samples;
    std::vector<std::string> overrides;
};

void compare(const Arguments& arguments) {
    const auto by_reference = timeline::Timeline::load(
        arguments.timeline,
        {kResolution, "clip.samples=1", test::by_reference(arguments.standard_error, kMostRays)});
    std::vector<std::string> overrides = {kResolution, "clip.samples=" + arguments.samples,
                                          "caustics={method: sliced_beams}"};
    overrides.insert(overrides.end(), arguments.overrides.begin(), arguments.overrides.end());
    const auto by_beams = timeline::Timeline::load(arguments.timeline, overrides);
    gpu::Device device{{}};
    render::FrameSceneBuilder reference_scenes, scenes;
    methods::SlicedBeams beams;
    std::vector<test::Series> series;
    double l1 = 0, sum = 0;
    for (int frame = arguments.first; frame <= arguments.last; ++frame) {
        const image::Image expected =
            test::kept_reference(reference_scenes.build(by_reference.at(frame)), arguments.folder, device);
        FrameStats stats;
        const image::Image found = test::scattered(scenes.build(by_beams.at(frame)), beams, device, stats);
        const std::size_t pixels = found.pixels();
        series.resize(3 * pixels);
        for (std::size_t c = 0; c < 3; ++c) {
            const std::string colour(1, "RGB"[c]);
            const std::vector<float>& s = test::channel(found, "S." + colour);
            const std::vector<float>& r = test::channel(expected, "S." + colour);
            const std::vector<float>& v = test::channel(expected, "S.variance." + colour);
            for (std::size_t i = 0; i < pixels; ++i) {
                const double difference = static_cast<double>(s[i]) - static_cast<double>(r[i]);
                series[3 * i + c].add(difference, static_cast<double>(r[i]), static_cast<double>(v[i]));
                l1 += std::abs(difference);
                sum += static_cast<double>(r[i]);
            }
        }
    }
    test::FlickerSums all, bands[kBands];
    for (std::size_t i = 0; i < series.size(); ++i) {
        all.add(series[i]);
        bands[i / 3 % kWidth * kBands / kWidth].add(series[i]);
    }
    all.print("all pixels", "S", static_cast<double>(series.size()));
    // The reference's errors in pixels near each other go together; those of upright bands hardly do.
    double mean = 0, squares = 0;
    for (const test::FlickerSums& band : bands) {
        const double scale = all.count * all.count / (band.count * all.reference * all.reference);
        const double flicker = (band.variance - band.reference_variance) * scale;
        mean += flicker / kBands;
        squares += flicker * flicker / kBands;
    }
    std::printf("standard error of the flicker, by %zu bands: %.1e\n", kBands,
                std::sqrt(std::max(0.0, squares - mean * mean) / (kBands - 1)));
    std::printf("relative L1 distance, frame by frame: %.4f\n", l1 / sum);
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 7) {
        std::fprintf(stderr,
                     "usage: scatter_flicker TIMELINE FOLDER FIRST LAST STANDARD_ERROR SAMPLES "
                     "[PATH=VALUE]...\n");
        return 2;
    }
    compare({argv[1],
             argv[2],
             std::atoi(argv[3]),
             std::atoi(argv[4]),
             argv[5],
             argv[6],
             {argv + 7, argv + argc}});
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
