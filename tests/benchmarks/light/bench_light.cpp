// What the beams of one light cost on a mesh of 2.1 million triangles, by kind of light and by what its waves
// make necessary: nothing, shadows of waves, second crossings. items_per_second: triangles, of all threads
// that parallel_for uses.
#include <benchmark/benchmark.h>

#include "light/water_beams.h"
#include "light/water_grids.h"  // of the tests

namespace {

using namespace dapple;

constexpr int kCells = 1024;

scene::FrameScene wavy_scene() {
    scene::FrameScene scene = test::water_scene({10, 10});
    test::add_water(scene, test::gentle_sea(), kCells, kCells);
    return scene;
}

scene::Light lamp(scene::LightType type, glm::dvec3 position) {
    scene::Light light;
    light.type = type;
    light.position = position;
    return light;
}

void water_beams(benchmark::State& state, const scene::Light& light, light::Event event) {
    static scene::FrameScene scene = wavy_scene();
    scene.state.lights = {light};
    const rays::RayScene rays(scene);
    for ([[maybe_unused]] auto _ : state) {
        FrameStats stats;
        benchmark::DoNotOptimize(light::water_beams<float>(scene, rays, {0, event}, 1, stats).size());
    }
    state.SetItemsProcessed(2 * kCells * kCells * state.iterations());
}
#define DAPPLE_WATER_BEAMS(name, ...)                 \
    BENCHMARK_CAPTURE(water_beams, name, __VA_ARGS__) \
        ->Unit(benchmark::kMillisecond)               \
        ->UseRealTime()                               \
        ->MeasureProcessCPUTime()
DAPPLE_WATER_BEAMS(sun_transmission, test::sun(30), light::Event::transmission);
DAPPLE_WATER_BEAMS(sun_reflection, test::sun(30), light::Event::reflection);
DAPPLE_WATER_BEAMS(low_sun_shadows, test::sun(88), light::Event::transmission);
DAPPLE_WATER_BEAMS(low_sun_crossings, test::sun(75), light::Event::reflection);
DAPPLE_WATER_BEAMS(point, lamp(scene::LightType::point, {1, 8, 2}), light::Event::transmission);
DAPPLE_WATER_BEAMS(spot, lamp(scene::LightType::spot, {1, 8, 2}), light::Event::transmission);
DAPPLE_WATER_BEAMS(low_lamp_reflection, lamp(scene::LightType::point, {1, 0.5, 2}), light::Event::reflection);

}  // namespace
