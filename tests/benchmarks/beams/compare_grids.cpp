// Beams of adaptive and of regular grids: how many they are, what they cost, and how far E on the floor and S
// of the water are off. Scenes: grid_scenes.h. compare_grids [SCENE [CELLS LEVELS]...]; by default all
// scenes, 16 cells with 0 to 5 levels and regular grids of 16 to 256.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "base/stats.h"
#include "grid_scenes.h"
#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/make_beams.h"
#include "view/camera_paths.h"

namespace {

using namespace dapple;
using namespace dapple::methods::adaptive_beams;

/// The picture, and the points along a pixel's side that its means are taken over.
constexpr int kWidth = 96, kHeight = 54;
constexpr int kPoints = 2;

/// Cells of the regular grid that the others are held against.
constexpr int kTruth = 512;

/// Means over pixels.
struct Picture {
    std::vector<double> e;  ///< W/m^2, green
    std::vector<double> s;  ///< W/m^2/sr, green
};

/// The scene, its pixels cut into kPoints squared parts.
scene::FrameScene finer(const scene::FrameScene& scene) {
    scene::FrameScene fine = scene;
    fine.state.clip.width = kWidth * kPoints;
    fine.state.clip.height = kHeight * kPoints;
    fine.state.clip.samples = 1;
    return fine;
}

std::vector<double> means(const std::vector<double>& points) {
    std::vector<double> pixels(static_cast<std::size_t>(kWidth) * kHeight, 0);
    constexpr std::size_t kColumns = static_cast<std::size_t>(kWidth) * kPoints;
    for (std::size_t i = 0; i < points.size(); ++i)
        pixels[i / kColumns / kPoints * kWidth + i % kColumns / kPoints] += points[i] / (kPoints * kPoints);
    return pixels;
}

/// What the camera sees, a point a fine pixel.
struct Seen {
    view::SegmentLayer segments;
    view::ReceiverLayer receivers;
    Seen(const scene::FrameScene& scene, const rays::RayScene& rays) {
        view::LayerCounts counts;
        receivers = view::trace_layer(scene, rays, {}, counts, &segments);
    }
};

/// CPU-s of a pass.
double seconds(const FrameStats& stats, std::string_view name) {
    double sum = 0;
    for (const PassTime& pass : stats.passes())
        if (pass.name == name) sum += pass.cpu_s;
    return sum;
}

struct Error {
    double l1 = 0, bias = 0;
};

Error error(const std::vector<double>& values, const std::vector<double>& truth) {
    Error result;
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        sum += truth[i];
        result.l1 += std::abs(values[i] - truth[i]);
        result.bias += values[i] - truth[i];
    }
    result.l1 *= 100 / sum;
    result.bias *= 100 / sum;
    return result;
}

struct Row {
    double beams = 0, fragments[2] = {0, 0}, prisms = 0;
    double made_s = 0, volumes_s = 0, raster_s = 0;  ///< CPU-s, the last two with six triangles
    Picture picture;
};

Row draw(const bench::GridScene& scene, const rays::RayScene& rays, gpu::Device& device, const Seen& seen,
         const scene::FrameScene& fine, int cells, int levels, bool both) {
    scene::FrameState& state = scene.frame->state;
    state.caustics.adaptive_beams.grid = cells;
    state.caustics.adaptive_beams.levels = levels;
    state.clip.width = kWidth;
    state.clip.height = kHeight;
    Row row;
    FrameStats stats;
    methods::FrameContext context{*scene.frame, rays, device, stats, scene.chains, {}};
    const double begin = cpu_seconds();
    const std::vector<BeamSet> sets = make_beams(context);
    row.made_s = cpu_seconds() - begin;
    row.beams = stats.counted("beams");
    BeamSums sums;
    for (const VolumeKind kind : {VolumeKind::prism, VolumeKind::six_triangles}) {
        if (kind == VolumeKind::prism && !both) continue;
        BeamRenderer renderer(device);
        FrameStats drawn;
        renderer.begin(fine, sets, kind, Shading::exact, drawn);
        sums = renderer.render(&seen.segments, &seen.receivers, drawn);
        row.fragments[kind == VolumeKind::prism ? 0 : 1] = drawn.counted("beam fragments");
        row.volumes_s = seconds(drawn, "beam volumes");
        row.raster_s = seconds(drawn, "beam raster");
        row.prisms = drawn.counted("beams in a prism");
    }
    std::vector<double> e, s;
    for (const glm::vec3& value : sums.irradiance) e.push_back(value.g);
    for (const glm::vec3& value : sums.scattered) s.push_back(value.g);
    row.picture = {means(e), means(s)};
    return row;
}

}  // namespace

int main(int argc, char** argv) {
    const auto number = [&](int i) { return std::atoi(argv[i]); };
    std::vector<std::array<int, 2>> grids;
    for (int i = 2; i + 1 < argc; i += 2) grids.push_back({number(i), number(i + 1)});
    if (grids.empty()) {
        for (int levels = 0; levels <= 5; ++levels) grids.push_back({16, levels});
        for (int cells = 32; cells <= 256; cells *= 2) grids.push_back({cells, 0});
    }
    gpu::Device device{gpu::DeviceOptions{}};
    for (int i = 0; i < 3; ++i) {
        if (argc > 1 && number(1) != i) continue;
        const bench::GridScene scene = bench::grid_scene(i);
        const rays::RayScene rays(*scene.frame);
        const scene::FrameScene fine = finer(*scene.frame);
        const Seen seen(fine, rays);
        const Picture truth = draw(scene, rays, device, seen, fine, kTruth, 0, false).picture;
        std::printf("%s\n", bench::kGridScenes[static_cast<std::size_t>(i)]);
        std::printf(
            "grid levels beams, M fragments of prisms and of six triangles, prisms among these; E: L1, bias "
            "%%; "
            "S: L1, bias %%; CPU-s: generation of beams, volumes, raster\n");
        for (const auto [cells, levels] : grids) {
            const Row row = draw(scene, rays, device, seen, fine, cells, levels, true);
            const Error e = error(row.picture.e, truth.e), s = error(row.picture.s, truth.s);
            std::printf("%4d %2d %7.0f %8.2f %8.2f %6.0f  %6.2f %+6.2f  %6.2f %+6.2f  %6.2f %6.2f %6.2f\n",
                        cells, levels, row.beams, 1e-6 * row.fragments[0], 1e-6 * row.fragments[1],
                        row.prisms, e.l1, e.bias, s.l1, s.bias, row.made_s, row.volumes_s, row.raster_s);
            std::fflush(stdout);
        }
    }
}
