// What the water's surface costs a frame, to be held against the tracing of its light: 1024 by 1024 cells.
#include <benchmark/benchmark.h>

#include "ocean/grid_mesh.h"
#include "ocean/water_surface.h"

namespace {

using namespace dapple;

scene::Water sum_of_24_waves() {
    scene::Water water;
    water.mesh_cells = 1024;
    for (int i = 0; i < 24; ++i) {
        water.surface.waves.waves.push_back(
            {.length = 0.25 + 0.1 * i, .heading = 0.3 * i, .amplitude = 0.01, .phase = 0.1 * i});
    }
    return water;
}

// 10 m hold 5 000 waves down to 0.25 m; 80 m hold 320 000.
scene::Water sea(double extent, double choppiness) {
    scene::Water water;
    water.mesh_cells = 1024;
    water.extent.size = {extent, extent};
    water.surface.type = scene::WaterSurfaceType::spectrum;
    water.surface.spectrum.choppiness = choppiness;
    return water;
}

void grid(benchmark::State& state, const scene::Water& water, ocean::FieldMask fields) {
    const ocean::WaterSurface surface(water);
    double time = 0;
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(surface.grid(time += 0.04, fields));
}

void mesh(benchmark::State& state, const scene::Water& water) {
    const ocean::WaterSurface surface(water);
    double time = 0;
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(surface.mesh(time += 0.04));
}

void tables(benchmark::State& state, const scene::Water& water) {
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(ocean::WaterSurface(water));
}

// CPU time is that of the whole process: the loops are parallel.
#define DAPPLE_BENCHMARK(...) \
    BENCHMARK_CAPTURE(__VA_ARGS__)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()

DAPPLE_BENCHMARK(grid, waves_height_slope, sum_of_24_waves(), ocean::kMeshFields);
DAPPLE_BENCHMARK(grid, sea_height_slope, sea(10, 0), ocean::kMeshFields);
DAPPLE_BENCHMARK(grid, sea_choppy, sea(10, 0.5), ocean::kChoppyMeshFields);
DAPPLE_BENCHMARK(mesh, waves, sum_of_24_waves());
DAPPLE_BENCHMARK(mesh, sea, sea(10, 0));
DAPPLE_BENCHMARK(mesh, choppy_sea, sea(10, 0.5));
DAPPLE_BENCHMARK(mesh, choppy_sea_of_320000_waves, sea(80, 0.5));
DAPPLE_BENCHMARK(tables, waves, sum_of_24_waves());
DAPPLE_BENCHMARK(tables, sea, sea(10, 0));
DAPPLE_BENCHMARK(tables, sea_of_320000_waves, sea(80, 0));

}  // namespace
