// How far S, the light that media scatter, of each method is from a frame of the reference:
//   scatter_error TIMELINE FOLDER FRAME STANDARD_ERROR [PATH=VALUE]...
// S is what pixels receive along the camera's first branch of light through or off the water; channels are
// summed up. The reference takes one camera path a pixel that stands for all of it; its frames are kept in
// FOLDER and used again. The methods take the clip's samples. Overrides of the timeline that begin with
// "clip." are for both sides, others for the methods only. Of each method there are, over all pixels and over
// those that show nothing by way of the water or a mirror, in %:
//   L1         sum of |difference| over the sum of the reference, as measured;
//   of noise   what of it the reference's own noise would give alone, were it normally distributed;
//   RMS less   the root mean square difference over the mean, the reference's own variance taken off
//              (negative: the root of what the difference is below the variance);
//   light      sum over the reference's, less 1, and three standard errors of the reference's sum as if
//              pixels were independent (they are not quite: a ray of light is seen by several).
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "accuracy/scatter_pictures.h"
#include "methods/adaptive_beams/adaptive_beams.h"
#include "methods/sliced_beams/sliced_beams.h"
#include "render/frame_scene_builder.h"
#include "timeline/timeline.h"

namespace {

using namespace dapple;

constexpr int kMostRays = 1000;  ///< of the reference, millions a light
constexpr int kMostLevels = 5;

struct Candidate {
    std::string name;
    std::string overrides;  ///< of the timeline's caustics
    std::function<std::unique_ptr<methods::CausticMethod>()> make;
};

std::vector<Candidate> candidates() {
    std::vector<Candidate> all = {{"sliced_beams", "caustics={method: sliced_beams}",
                                   [] { return std::make_unique<methods::SlicedBeams>(); }}};
    for (int level = 0; level <= kMostLevels; ++level) {
        const std::string levels = std::to_string(level);
        all.push_back({"adaptive_beams, " + levels + " levels",
                       "caustics={method: adaptive_beams, levels: " + levels + "}",
                       [] { return std::make_unique<methods::AdaptiveBeams>(); }});
    }
    return all;
}

/// Sums over the channels of pixels.
struct Sums {
    double l1 = 0, squares = 0, found = 0, reference = 0, variance = 0, deviation = 0, count = 0;
    void add(float s, float r, float v) {
        const double difference = static_cast<double>(s) - static_cast<double>(r);
        l1 += std::abs(difference);
        squares += difference * difference;
        found += static_cast<double>(s);
        reference += static_cast<double>(r);
        variance += static_cast<double>(v);
        deviation += std::sqrt(static_cast<double>(v));
        ++count;
    }
    void print() const {
        // Of a normal distribution E|x| = sqrt(2 / pi) sigma.
        const double noise_l1 = std::sqrt(2 / std::numbers::pi) * deviation / reference;
        const double less = (squares - variance) / count;
        const double rms = std::copysign(std::sqrt(std::abs(less)), less) / (reference / count);
        // The three channels' light is that of the same rays: there their errors add, not their squares.
        const double noise_of_sum = std::sqrt(3 * variance) / reference;
        std::printf(" | %7.3f %8.3f %8.3f %+7.3f +- %6.3f", 100 * l1 / reference, 100 * noise_l1, 100 * rms,
                    100 * (found / reference - 1), 300 * noise_of_sum);
    }
};

void print(const std::string& name, const image::Image& found, const image::Image& expected, double cpu_s) {
    Sums all, direct;
    for (const char colour : {'R', 'G', 'B'}) {
        const std::vector<float>& s = test::channel(found, std::string("S.") + colour);
        const std::vector<float>& r = test::channel(expected, std::string("S.") + colour);
        const std::vector<float>& v = test::channel(expected, std::string("S.variance.") + colour);
        for (std::size_t i = 0; i < s.size(); ++i) {
            all.add(s[i], r[i], v[i]);
            const bool both =
                test::channel(found, "direct")[i] > 0 && test::channel(expected, "direct")[i] > 0;
            if (both) direct.add(s[i], r[i], v[i]);
        }
    }
    std::printf("%-24s", name.c_str());
    all.print();
    direct.print();
    std::printf(" | %8.1f %5.1f\n", 100 * direct.count / all.count, cpu_s);
    std::fflush(stdout);
}

void compare(const std::string& timeline, const std::string& folder, int frame,
             const std::string& standard_error, const std::vector<std::string>& overrides) {
    gpu::Device device{{}};
    std::vector<std::string> of_reference;
    for (const std::string& setting : overrides)
        if (setting.starts_with("clip.")) of_reference.push_back(setting);
    of_reference.insert(of_reference.end(),
                        {"clip.samples=1", test::by_reference(standard_error, kMostRays)});
    render::FrameSceneBuilder reference_scenes;
    const image::Image expected = test::kept_reference(
        reference_scenes.build(timeline::Timeline::load(timeline, of_reference).at(frame)), folder, device);
    constexpr const char* kHeads = "     L1 of noise RMS less             light";
    std::printf("%-24s | %-43s| %-43s|\n", "", "all pixels", "nothing between");
    std::printf("%-24s | %-43s| %-43s| %% of all CPU-s\n", "S, %", kHeads, kHeads);
    for (const Candidate& candidate : candidates()) {
        std::vector<std::string> settings = {candidate.overrides};
        settings.insert(settings.end(), overrides.begin(), overrides.end());
        render::FrameSceneBuilder scenes;
        const scene::FrameScene scene = scenes.build(timeline::Timeline::load(timeline, settings).at(frame));
        FrameStats stats;
        const double begin = cpu_seconds();
        const std::unique_ptr<methods::CausticMethod> method = candidate.make();
        const image::Image found = test::scattered(scene, *method, device, stats);
        print(candidate.name, found, expected, cpu_seconds() - begin);
    }
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 5) {
        std::fprintf(stderr, "usage: scatter_error TIMELINE FOLDER FRAME STANDARD_ERROR [PATH=VALUE]...\n");
        return 2;
    }
    compare(argv[1], argv[2], std::atoi(argv[3]), argv[4], {argv + 5, argv + argc});
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
