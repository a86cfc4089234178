// drawn: E and S of 240 x 135 pixels under water in a pool of 5 m x 5 m, 2 m deep, by rasterised beams.
// Arguments: triangles of the water, in thousands about; the kind of volume (0: prism, 1: six triangles); the
// shading (0: exact, 1: as in the paper).
// raw_fill: the same volumes, a constant added into the same two targets. ns_a_fragment is device time, cpu_s
// process CPU time of all threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "base/stats.h"
#include "gpu/pass_list.h"
#include "light/water_beams.h"
#include "methods/adaptive_beams/beam_renderer.h"
#include "methods/adaptive_beams/drawn_beams.h"
#include "methods/drawn_sheets.h"
#include "ocean/water_surface.h"
#include "spiral_sea.h"
#include "spirv/test_two_colors_frag.h"
#include "spirv/test_volumes_vert.h"
#include "view/camera_paths.h"

namespace {

using namespace dapple;
using namespace dapple::methods::adaptive_beams;

scene::FrameScene pool(int cells) {
    scene::FrameScene scene;
    scene::FrameState& state = scene.state;
    state.clip.width = 240;
    state.clip.height = 135;
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
    scene::Object floor;
    floor.size = {5, 1, 5};
    floor.transform.position = {0, -2, 0};
    state.objects.push_back(floor);
    scene.object_meshes.resize(1);
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    return scene;
}

gpu::Device& shared_device() {
    static gpu::Device device(gpu::DeviceOptions{});
    return device;
}

int cells_of(const benchmark::State& state) {
    return static_cast<int>(std::lround(std::sqrt(500.0 * static_cast<double>(state.range(0)))));
}

VolumeKind kind_of(const benchmark::State& state) {
    return state.range(1) == 0 ? VolumeKind::prism : VolumeKind::six_triangles;
}

double device_seconds(const FrameStats& stats) {
    double sum = 0;
    for (const PassTime& pass : stats.passes())
        if (pass.name == "beam raster") sum += pass.device_s;
    return sum;
}

void drawn(benchmark::State& state) {
    const scene::FrameScene scene = pool(cells_of(state));
    const rays::RayScene rays(scene);
    const std::vector<BeamSet> sets = test::drawn_sheets(scene, rays, 2);
    view::LayerCounts layer_counts;
    view::SegmentLayer segments;
    const view::ReceiverLayer receivers = view::trace_layer(scene, rays, {}, layer_counts, &segments);
    BeamRenderer renderer(shared_device());
    FrameStats warm;
    renderer.begin(scene, sets, kind_of(state), state.range(2) == 0 ? Shading::exact : Shading::paper, warm);
    renderer.render(&segments, &receivers, warm);
    FrameStats stats;
    const double cpu = cpu_seconds();
    for ([[maybe_unused]] auto _ : state) renderer.render(&segments, &receivers, stats);
    const double fragments = warm.counted("beam fragments"), runs = static_cast<double>(state.iterations());
    state.counters["fragments"] = fragments;
    state.counters["cpu_s"] = (cpu_seconds() - cpu) / runs;
    state.counters["ns_a_fragment"] = 1e9 * device_seconds(stats) / (runs * fragments);
    state.counters["cpu_ns_a_fragment"] = 1e9 * (cpu_seconds() - cpu) / (runs * fragments);
    state.counters["listed"] =
        warm.counted("beams with turning areas") / std::max(1.0, warm.counted("beams drawn"));
    state.counters["volumes_s"] = warm.passes().front().wall_s;
}

void raw_fill(benchmark::State& state) {
    const scene::FrameScene scene = pool(cells_of(state));
    const rays::RayScene rays(scene);
    const view::Camera camera(scene.state.camera, scene.state.clip.width, scene.state.clip.height);
    const DrawnBeams beams =
        drawn_beams(test::drawn_sheets(scene, rays, 2).front(), camera, scene.origin, kind_of(state), 0.5);
    gpu::Device& device = shared_device();
    const gpu::RasterPipeline pipeline(device, "volumes", test_volumes_vert, test_two_colors_frag,
                                       {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                                        .blend = gpu::Blend::add,
                                        .cull = gpu::Cull::front,
                                        .color_formats = {gpu::Format::rgba32f, gpu::Format::rgba32f}});
    const auto image = [&](const char* name) {
        return gpu::Image(device, name, scene.state.clip.width, scene.state.clip.height,
                          gpu::Format::rgba32f);
    };
    const gpu::Image first = image("first"), second = image("second");
    gpu::Buffer corners(device, "corners", beams.corners.size() * sizeof(glm::vec3));
    std::copy(beams.corners.begin(), beams.corners.end(), corners.as<glm::vec3>().begin());
    gpu::Buffer indices(device, "indices", beams.indices.size() * sizeof(std::uint32_t));
    std::copy(beams.indices.begin(), beams.indices.end(), indices.as<std::uint32_t>().begin());
    const std::size_t pixels =
        static_cast<std::size_t>(first.width()) * static_cast<std::size_t>(first.height());
    gpu::Buffer out(device, "out", pixels * sizeof(glm::vec4));
    const auto run = [&](FrameStats& stats) {
        gpu::PassList passes(device);
        gpu::Bindings bindings{.buffers = {&corners}};
        bindings.set_push(glm::vec2(first.width(), first.height()));
        passes.draw("beam raster", pipeline, bindings, {.colors = {&first, &second}},
                    {.vertices = static_cast<std::uint32_t>(beams.indices.size()), .index_buffer = &indices});
        passes.copy("read back", first, out);
        passes.run(stats);
    };
    FrameStats warm, stats;
    run(warm);
    double fragments = 0;
    for (const glm::vec4& texel : out.as<glm::vec4>()) fragments += static_cast<double>(texel.x);
    for ([[maybe_unused]] auto _ : state) run(stats);
    state.counters["fragments"] = fragments;
    state.counters["ns_a_fragment"] =
        1e9 * device_seconds(stats) / (static_cast<double>(state.iterations()) * fragments);
}

void arguments(benchmark::internal::Benchmark* all) {
    all->ArgNames({"thousand", "six", "paper"})
        ->Args({5, 1, 0})
        ->Args({5, 0, 0})
        ->Args({5, 1, 1})
        ->Args({20, 1, 0});
    all->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);
}
BENCHMARK(drawn)->Apply(arguments);
BENCHMARK(raw_fill)->Apply(arguments);

}  // namespace

BENCHMARK_MAIN();
