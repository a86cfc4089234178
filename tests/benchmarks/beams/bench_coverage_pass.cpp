// Coverage of a frame of a pool on the CPU and as a compute pass on the default device: arguments are cells
// along x, what the receivers are, and whether the device computes. cpu_s is process
// CPU time of all threads, which on a device without a processor of its own is all there is.
#include <benchmark/benchmark.h>

#include "methods/coverage_scene.h"

namespace {

using namespace dapple;
using methods::CoverageBackend;

enum Receivers : std::int64_t { kPool, kFloor, kSphere };

void coverage_pass(benchmark::State& bench) {
    static gpu::Device device{gpu::DeviceOptions{}};
    scene::FrameScene scene = test::pool_scene(1024, 576, static_cast<int>(bench.range(0)), 0);
    std::vector<scene::Object>& objects = scene.state.objects;
    if (bench.range(1) == kFloor) objects.resize(1);
    if (bench.range(1) == kSphere) {
        objects = {objects[4]};
        objects[0].radius = 20;
        objects[0].transform.position.y = -21.5;
    }
    test::CoverageFrame frame(device, scene);
    methods::SlicedBeams method(bench.range(2) != 0 ? CoverageBackend::compute : CoverageBackend::cpu);
    FrameStats first;
    frame.irradiance(method, first);  // shaders are compiled at their first use
    double cpu_s = 0, wall_s = 0, device_s = 0, on_device = 0, pairs = 0;
    for (auto _ : bench) {
        FrameStats stats;
        frame.irradiance(method, stats);
        for (const PassTime& pass : stats.passes()) {
            if (pass.name != "coverage") continue;
            cpu_s += pass.cpu_s;
            wall_s += pass.wall_s;
            device_s += pass.device_s;
        }
        on_device = stats.counted("tiles covered on the device");
        pairs = stats.counted("caustic shadow rays");
    }
    const double n = static_cast<double>(bench.iterations());
    bench.counters["cpu_s"] = cpu_s / n;
    bench.counters["device_s"] = device_s / n;
    bench.counters["wall_s"] = wall_s / n;
    bench.counters["tiles_on_device"] = on_device;
    bench.counters["shadow_rays_M"] = pairs * 1e-6;
}
BENCHMARK(coverage_pass)
    ->ArgsProduct({{256, 512, 1024}, {kPool, kFloor, kSphere}, {0, 1}})
    ->ArgNames({"cells", "receivers", "device"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
