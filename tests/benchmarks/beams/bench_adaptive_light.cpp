// make: the light side of adaptive beams, by its own passes: grids of 16 cells a side with 0 to 5 levels, and
// regular ones of 16 to 256. Arguments: number of the scene in
// grid_scenes.h, cells, levels. `beams`, on all legs; `carried`: share of the
// light that meets the body and is not lost at silhouettes.
#include <benchmark/benchmark.h>

#include "grid_scenes.h"
#include "methods/adaptive_beams/make_beams.h"

namespace {

using namespace dapple;

void make(benchmark::State& run) {
    const bench::GridScene scene = bench::grid_scene(static_cast<int>(run.range(0)));
    scene.frame->state.clip.width = 960;
    scene.frame->state.clip.height = 540;
    auto& settings = scene.frame->state.caustics.adaptive_beams;
    settings.grid = static_cast<int>(run.range(1));
    settings.levels = static_cast<int>(run.range(2));
    const rays::RayScene rays(*scene.frame);
    gpu::Device device{gpu::DeviceOptions{}};
    FrameStats stats;
    for (auto _ : run) {
        stats = {};
        methods::FrameContext context{*scene.frame, rays, device, stats, scene.chains};
        benchmark::DoNotOptimize(methods::adaptive_beams::make_beams(context));
    }
    run.counters["beams"] = stats.counted("beams");
    const double met = stats.counted("light on specular surfaces, W");
    run.counters["carried"] = 1 - stats.counted("lost at silhouettes, W") / met;
    for (const PassTime& pass : stats.passes()) {
        // "beam grid" and so on, in ms
        run.counters[pass.name + " ms"] = 1e3 * pass.wall_s;
    }
}

void grids(benchmark::internal::Benchmark* bench) {
    for (const int scene : {0, 1, 2}) {
        for (int levels = 0; levels <= 5; ++levels) bench->Args({scene, 16, levels});
        for (int cells = 16; cells <= 256; cells *= 2) bench->Args({scene, cells, 0});
    }
}

BENCHMARK(make)->Apply(grids)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
