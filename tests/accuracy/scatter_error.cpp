// How far S, the light that media scatter, of each method is from a frame of the reference:
//   scatter_error TIMELINE FOLDER FRAME STANDARD_ERROR REFERENCES LIMIT [PATH=VALUE]...
// S is what pixels receive along the camera's first branch of light through or off the water; channels are
// summed up. The reference takes one camera path a pixel that stands for all of it. REFERENCES (an even
// number) of its frames, of STANDARD_ERROR each and seeds of their own, are kept in FOLDER and used again;
// what is compared with is their mean. Half the difference of the first half's mean and the other's is
// distributed as that mean's own error is, with all that neighbours share of it: the noise. The methods take
// the clip's samples. Overrides of the timeline that begin with "clip." are for both sides, others for the
// methods only. Of each method there are, over all pixels and over those that show nothing by way of the
// water or a mirror, in %:
//   L1         sum of |difference| over the sum of the reference, as measured, of pixels and of means over
//              blocks of 4 x 4 and 8 x 8 of them;
//   noise      what the reference's own noise would give alone there;
//   RMS less   the root mean square difference of pixels over the mean, the noise's taken off (negative: the
//              root of what the difference is below it). Their L1 without noise is no larger than that;
//   light      sum over the reference's, less 1, and three standard errors of the reference's sum as if
//              pixels were independent (they are not quite: a ray of light is seen by several).
// Ends with 6 where the first method's L1 over all blocks of 4 x 4 pixels, noise and all, exceeds LIMIT
// percent.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
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

/// What is compared with: S of the reference, and a picture that is distributed as its error is.
struct Expected {
    image::Image mean;
    std::array<std::vector<float>, 3> noise, variance;
};

Expected expected_of(const std::vector<image::Image>& references) {
    Expected expected{references.front(), {}, {}};
    const auto count = static_cast<float>(references.size());
    for (std::size_t c = 0; c < 3; ++c) {
        const std::string name = std::string("S.") + "RGB"[c],
                          of_error = std::string("S.variance.") + "RGB"[c];
        std::vector<float>& mean = expected.mean.find(name)->values;
        mean.assign(mean.size(), 0);
        expected.noise[c] = expected.variance[c] = mean;
        for (std::size_t k = 0; k < references.size(); ++k) {
            const float sign = 2 * k < references.size() ? 1 : -1;
            const std::vector<float>& s = test::channel(references[k], name);
            const std::vector<float>& v = test::channel(references[k], of_error);
            for (std::size_t i = 0; i < mean.size(); ++i) {
                mean[i] += s[i] / count;
                expected.noise[c][i] += sign * s[i] / count;
                expected.variance[c][i] += v[i] / (count * count);
            }
        }
    }
    return expected;
}

struct Errors {
    double l1 = 0, noise = 0, rms = 0, light = 0, light_error = 0;  ///< %
    double pixels = 0;                                              ///< shares of all, %
};

/// Of means over blocks of `side` x `side` pixels, of those pixels alone that `chosen` names.
Errors errors(const image::Image& found, const Expected& expected, const std::vector<char>& chosen,
              int side) {
    const auto width = static_cast<std::size_t>(found.width), size = static_cast<std::size_t>(side);
    const std::size_t across = (width + size - 1) / size,
                      blocks = across * ((found.pixels() / width + size - 1) / size);
    double l1 = 0, noise = 0, squares = 0, all_found = 0, all_expected = 0, variance = 0, pixels = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::string name = std::string("S.") + "RGB"[c];
        const std::vector<float>&s = test::channel(found, name), &r = test::channel(expected.mean, name);
        std::vector<double> difference(blocks, 0), of_noise(blocks, 0);
        for (std::size_t i = 0; i < s.size(); ++i) {
            if (!chosen[i]) continue;
            const std::size_t block = i / width / size * across + i % width / size;
            difference[block] += static_cast<double>(s[i]) - static_cast<double>(r[i]);
            of_noise[block] += static_cast<double>(expected.noise[c][i]);
            all_found += static_cast<double>(s[i]);
            all_expected += static_cast<double>(r[i]);
            variance += static_cast<double>(expected.variance[c][i]);
            ++pixels;
        }
        for (std::size_t block = 0; block < blocks; ++block) {
            l1 += std::abs(difference[block]);
            noise += std::abs(of_noise[block]);
            squares += difference[block] * difference[block] - of_noise[block] * of_noise[block];
        }
    }
    Errors result;
    result.l1 = 100 * l1 / all_expected;
    result.noise = 100 * noise / all_expected;
    result.rms = 100 * std::copysign(std::sqrt(std::abs(squares) * pixels), squares) / all_expected;
    result.light = 100 * (all_found / all_expected - 1);
    // The three channels' light is that of the same rays: there their errors add, not their squares.
    result.light_error = 300 * std::sqrt(3 * variance) / all_expected;
    result.pixels = 100 * pixels / (3 * static_cast<double>(chosen.size()));
    return result;
}

/// Two lines of the table. Returns L1 of the blocks that the verdict is about.
double print(const std::string& name, const image::Image& found, const Expected& expected, double cpu_s) {
    const std::vector<char> all(found.pixels(), 1);
    std::vector<char> direct(found.pixels(), 0);
    for (std::size_t i = 0; i < direct.size(); ++i)
        if (test::channel(found, "direct")[i] > 0 && test::channel(expected.mean, "direct")[i] > 0)
            direct[i] = 1;
    const auto line = [&](const std::vector<char>& pixels, const std::string& what) {
        const Errors one = errors(found, expected, pixels, 1), four = errors(found, expected, pixels, 4),
                     eight = errors(found, expected, pixels, 8);
        std::printf("%-35s | %5.1f | %7.3f %7.3f %8.3f | %7.3f %7.3f | %7.3f %7.3f | %+7.3f +- %.3f\n",
                    what.c_str(), one.pixels, one.l1, one.noise, one.rms, four.l1, four.noise, eight.l1,
                    eight.noise, one.light, one.light_error);
        return four.l1;
    };
    const double over_blocks = line(all, name + ", " + std::to_string(std::lround(cpu_s)) + " CPU-s");
    line(direct, "  nothing between");
    std::fflush(stdout);
    return over_blocks;
}

struct Job {
    std::string timeline, folder;
    int frame = 0;
    std::string standard_error;
    int references = 0;
    double limit = 0;  ///< %
    std::vector<std::string> overrides;
};

std::vector<image::Image> kept_references(const Job& job, gpu::Device& device) {
    std::vector<image::Image> references;
    for (int seed = 1; seed <= job.references; ++seed) {
        std::vector<std::string> settings;
        for (const std::string& setting : job.overrides)
            if (setting.starts_with("clip.")) settings.push_back(setting);
        settings.insert(settings.end(), {"clip.samples=1", "clip.seed=" + std::to_string(seed),
                                         test::by_reference(job.standard_error, kMostRays)});
        const std::string folder = job.folder + "/seed" + std::to_string(seed);
        std::filesystem::create_directories(folder);
        render::FrameSceneBuilder scenes;
        references.push_back(test::kept_reference(
            scenes.build(timeline::Timeline::load(job.timeline, settings).at(job.frame)), folder, device));
    }
    return references;
}

/// Whether the first method keeps to the limit.
bool compare(const Job& job) {
    gpu::Device device{{}};
    const Expected expected = expected_of(kept_references(job, device));
    std::printf("%-35s | %5s | %-24s | %-15s | %-15s | light\n", "", "% of", "pixels", "4 x 4", "8 x 8");
    std::printf("%-35s | %5s | %7s %7s %8s | %7s %7s | %7s %7s |\n", "S, %", "all", "L1", "noise", "RMS less",
                "L1", "noise", "L1", "noise");
    std::optional<double> of_first;
    for (const Candidate& candidate : candidates()) {
        std::vector<std::string> settings = {candidate.overrides};
        settings.insert(settings.end(), job.overrides.begin(), job.overrides.end());
        render::FrameSceneBuilder scenes;
        const scene::FrameScene scene =
            scenes.build(timeline::Timeline::load(job.timeline, settings).at(job.frame));
        FrameStats stats;
        const double begin = cpu_seconds();
        const std::unique_ptr<methods::CausticMethod> method = candidate.make();
        const image::Image found = test::scattered(scene, *method, device, stats);
        const double error = print(candidate.name, found, expected, cpu_seconds() - begin);
        if (!of_first) of_first = error;
    }
    const bool holds = *of_first <= job.limit;
    std::printf("%s over blocks of 4 x 4 pixels: L1 %.2f %%, noise and all; at most %g %%: %s\n",
                candidates().front().name.c_str(), *of_first, job.limit, holds ? "holds" : "FAILS");
    return holds;
}

}  // namespace

int main(int argc, char** argv) try {
    const int references = argc > 5 ? std::atoi(argv[5]) : 0;
    if (argc < 7 || references < 2 || references % 2 != 0) {
        std::fprintf(stderr,
                     "usage: scatter_error TIMELINE FOLDER FRAME STANDARD_ERROR REFERENCES LIMIT "
                     "[PATH=VALUE]...; an even number of references\n");
        return 2;
    }
    const bool holds = compare({argv[1],
                                argv[2],
                                std::atoi(argv[3]),
                                argv[4],
                                references,
                                std::atof(argv[6]),
                                {argv + 7, argv + argc}});
    return holds ? 0 : 6;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
