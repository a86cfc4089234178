// scatter: S of 960 x 540 camera segments in a pool of 5 m x 5 m, 2 m deep, about 100 000 beams, even water;
// the camera is under water. Arguments: cells along x, directions of the sun's disc. scatter_pass: the same
// of one row of pixels in 16, in bands of 8, on the CPU and on the default device; build_cpu_s is what comes
// once a frame. edges_alone: the raw limit, the quadratic test of beams that lie side by side against
// segments that cross all of them, without finding them or integrating. cpu_s is process CPU time of all
// threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <optional>
#include <vector>

#include "base/stats.h"
#include "light/water_beams.h"
#include "methods/sliced_beams/volume_light.h"
#include "ocean/water_surface.h"
#include "spiral_sea.h"
#include "view/camera.h"

namespace {

using namespace dapple;
using namespace dapple::methods::sliced_beams;

constexpr int kWidth = 960, kHeight = 540;

scene::FrameScene pool(int cells) {
    scene::FrameScene scene;
    scene::FrameState& state = scene.state;
    state.clip.width = kWidth;
    state.clip.height = kHeight;
    state.clip.samples = 1;
    scene::Water& water = state.water.emplace();
    water.extent.size = {5, 5};
    water.mesh_cells = cells;
    water.absorption = {0.35, 0.06, 0.03};
    water.scattering = {0.1, 0.1, 0.1};
    water.phase.type = scene::PhaseType::henyey_greenstein;
    bench::add_waves(water, 0.25, 2, 0.006);
    scene::Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.5, -0.8660254, 0));
    state.lights.push_back(sun);
    state.camera.position = {0, -0.8, 2.3};
    state.camera.target = {0, -0.9, 0};
    state.camera.field_of_view = 0.9;
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    return scene;
}

/// One segment a pixel, from the camera to the walls, the floor or the rest plane of the water; of one band
/// of 8 rows in `bands`.
view::SegmentLayer segments(const scene::FrameState& state, int bands) {
    const view::Camera view(state.camera, kWidth, kHeight);
    view::SegmentLayer layer;
    layer.width = kWidth;
    for (int i = 0; i < kWidth * kHeight; ++i) {
        glm::dvec3 origin, direction;
        const int column = i % kWidth, row = i / kWidth;
        if (row / 8 % bands != 0) continue;
        view.ray({column + 0.5, row + 0.5}, origin, direction);
        const glm::dvec3 low(-2.5, -2, -2.5), high(2.5, 0, 2.5);
        const glm::dvec3 to = glm::mix(low, high, glm::greaterThan(direction, glm::dvec3(0)));
        const glm::dvec3 far = (to - origin) / direction;
        layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
        layer.origin.emplace_back(origin);
        layer.direction.emplace_back(direction);
        layer.length.push_back(static_cast<float>(std::min({far.x, far.y, far.z})));
        layer.in_water.push_back(1);
        layer.primary.push_back(1);
    }
    layer.first.push_back(static_cast<std::uint32_t>(layer.origin.size()));
    layer.height = static_cast<int>(layer.origin.size()) / kWidth;
    return layer;
}

void scatter(benchmark::State& bench) {
    scene::FrameScene scene = pool(static_cast<int>(bench.range(0)));
    scene.state.caustics.sliced_beams.volume_sun_samples = static_cast<int>(bench.range(1));
    const rays::RayScene rays(scene);
    const view::SegmentLayer layer = segments(scene.state, 1);
    std::vector<std::unique_ptr<SheetCoverage<float>>> sheets;
    FrameStats stats;
    for (auto& sheet : light::water_beams<float>(scene, rays, {0, light::Event::transmission}, 1, stats))
        sheets.push_back(std::make_unique<SheetCoverage<float>>(scene, rays, std::move(sheet), 2.6f));
    double cpu_s = 0, mean = 0;
    ScatterCounts counts;
    for (auto _ : bench) {
        counts = {};
        const double before = cpu_seconds();
        const VolumeLight volume(scene, sheets, stats);
        std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
        volume.add(layer, radiance, counts);
        cpu_s += cpu_seconds() - before;
        mean = 0;
        for (const glm::vec3& s : radiance)
            mean += static_cast<double>(s.y) / static_cast<double>(radiance.size());
    }
    cpu_s /= static_cast<double>(bench.iterations());
    const double n = static_cast<double>(layer.segments());
    bench.counters["beams"] = static_cast<double>(scene.water->mesh.triangles.size());
    bench.counters["cpu_s"] = cpu_s;
    bench.counters["intervals_a_segment"] = static_cast<double>(counts.intervals) / n;
    bench.counters["beams_tested"] = static_cast<double>(counts.beams) / n;
    bench.counters["peaks_percent"] =
        100 * static_cast<double>(counts.peaks) / static_cast<double>(counts.intervals);
    bench.counters["M_intervals_per_cpu_s"] = 1e-6 * static_cast<double>(counts.intervals) / cpu_s;
    bench.counters["mean_S"] = mean;
}
BENCHMARK(scatter)->Args({224, 1})->Args({224, 4})->Unit(benchmark::kMillisecond)->UseRealTime();

void scatter_pass(benchmark::State& bench) {
    const scene::FrameScene scene = pool(224);
    const rays::RayScene rays(scene);
    const view::SegmentLayer layer = segments(scene.state, 16);
    std::vector<std::unique_ptr<SheetCoverage<float>>> sheets;
    FrameStats stats;
    for (auto& sheet : light::water_beams<float>(scene, rays, {0, light::Event::transmission}, 1, stats))
        sheets.push_back(std::make_unique<SheetCoverage<float>>(scene, rays, std::move(sheet), 2.6f));
    std::optional<gpu::Device> device;
    std::optional<ScatterPass> pass;
    if (bench.range(0) != 0) pass.emplace(device.emplace(gpu::DeviceOptions{}));
    std::vector<glm::vec3> radiance(layer.segments(), glm::vec3(0));
    double build_s = cpu_seconds();
    const VolumeLight volume(scene, sheets, stats, pass ? &*pass : nullptr);
    build_s = cpu_seconds() - build_s;
    ScatterCounts counts;
    if (pass) {  // its shader is compiled at its first use
        view::SegmentLayer row = layer;
        row.height = 1;
        row.first.resize(kWidth + 1);
        volume.add_on_device(row, radiance, counts, stats);
    }
    double cpu_s = 0;
    for (auto _ : bench) {
        const double before = cpu_seconds();
        volume.add(layer, radiance, counts);
        volume.add_on_device(layer, radiance, counts, stats);
        cpu_s += cpu_seconds() - before;
    }
    const double n = static_cast<double>(bench.iterations()) * static_cast<double>(layer.segments());
    bench.counters["build_cpu_s"] = build_s;
    bench.counters["us_cpu_a_segment"] = 1e6 * cpu_s / n;
}
BENCHMARK(scatter_pass)->ArgName("device")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

void edges_alone(benchmark::State& bench) {
    constexpr int kBeams = 1024;
    std::vector<std::array<BeamCorner<float>, 3>> beams(kBeams);
    for (int i = 0; i < kBeams; ++i) {
        const float at = 0.01f * static_cast<float>(i);
        const auto corner = [&](float a, float b) {
            return BeamCorner<float>{a, b, 0.03f * std::sin(9 * a), 0.03f * std::cos(7 * b), 0};
        };
        beams[static_cast<std::size_t>(i)] = {corner(at, -0.01f), corner(at + 0.02f, -0.01f),
                                              corner(at + 0.01f, 0.01f)};
    }
    double cpu_s = 0;
    std::size_t intervals = 0;
    for (auto _ : bench) {
        const double before = cpu_seconds();
        Lanes<float> length{};
        for (const auto& beam : beams) {
            SegmentParts<float> part{};
            part.a = splat(beam[0].a + 0.01f);
            part.b = splat(0.015f);
            part.half_a = splat(0.02f);
            part.depth = splat(0.5f) + Lanes<float>{0, 1e-3f, 2e-3f, 3e-3f, 4e-3f, 5e-3f, 6e-3f, 7e-3f};
            part.half_depth = splat(0.002f);
            const BeamCorner<float> corners[3] = {beam[0], beam[1], beam[2]};
            visit_pieces(slices(corners, part), Mask<float>{} == 0,
                         [&](const Lanes<float>& enter, const Lanes<float>& leave, const Mask<float>& mask) {
                             length += mask ? leave - enter : Lanes<float>{};
                             intervals += static_cast<std::size_t>(__builtin_popcount(bits(mask)));
                         });
        }
        benchmark::DoNotOptimize(length);
        cpu_s += cpu_seconds() - before;
    }
    bench.counters["M_intervals_per_cpu_s"] = 1e-6 * static_cast<double>(intervals) / cpu_s;
}
BENCHMARK(edges_alone);

}  // namespace

BENCHMARK_MAIN();
