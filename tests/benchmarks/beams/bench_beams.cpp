// What sliced_beams costs by itself: beams, pyramid and coverage of a million receivers on a curved and
// sloped floor, seen in perspective, under 24 waves, without shadow rays. Arguments: cells along x, depth of
// the floor [m]. cpu_s is process CPU time of all threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "base/stats.h"
#include "light/water_beams.h"
#include "methods/sliced_beams/layer_tiles.h"
#include "methods/sliced_beams/point_query.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "ocean/water_surface.h"
#include "view/camera.h"

namespace {

using namespace dapple;
using methods::sliced_beams::LayerTiles;
using methods::sliced_beams::QueryCounts;
using methods::sliced_beams::ReceiverGroup;
using methods::sliced_beams::SheetCoverage;

constexpr int kSide = 1024;

/// Lengths of 0.15 to 1.2 m in equal ratios, amplitude 0.0032 of the length, in all directions.
scene::FrameState sea(int cells) {
    scene::FrameState state;
    state.clip.width = state.clip.height = kSide;
    state.clip.samples = 1;
    scene::Water& water = state.water.emplace();
    water.extent.size = {12, 12};
    water.mesh_cells = cells;
    for (int i = 0; i < 24; ++i) {
        scene::Wave wave;
        wave.length = 0.15 * std::pow(8.0, i / 23.0);
        wave.heading = 2.399963229728653 * i;
        wave.amplitude = 0.0032 * wave.length;
        wave.phase = 1.7 * i * i;
        const double k = 2 * 3.141592653589793 / wave.length;
        wave.wave_vector = k * glm::dvec2(std::cos(wave.heading), std::sin(wave.heading));
        water.surface.waves.waves.push_back(wave);
    }
    scene::Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.5, -0.8660254, 0));
    sun.angular_diameter = 0;
    state.lights.push_back(sun);
    state.camera.position = {0, -0.3, 2.2};
    state.camera.field_of_view = 1.0;
    return state;
}

/// Where a camera's rays meet the floor y = -depth (1 + 0.1 sin x cos z + 0.05 x), by fixed-point steps.
view::ReceiverLayer floor_layer(const scene::FrameState& state, double depth) {
    scene::Camera camera = state.camera;
    camera.target = {0, -depth, 0};
    const view::Camera view(camera, kSide, kSide);
    view::ReceiverLayer layer;
    layer.width = layer.height = kSide;
    layer.flags.assign(layer.pixels(), view::kReceiver | view::kInWater);
    layer.object.assign(layer.pixels(), 0);
    layer.position.resize(layer.pixels());
    layer.footprint_u.resize(layer.pixels());
    layer.footprint_v.resize(layer.pixels());
    layer.shading_normal.resize(layer.pixels());
    const auto height = [&](double x, double z) {
        return -depth * (1 + 0.1 * std::sin(x) * std::cos(z) + 0.05 * x);
    };
    const auto meet = [&](double x, double y) {
        glm::dvec3 origin, direction;
        view.ray({x, y}, origin, direction);
        glm::dvec3 point = origin + (depth / -direction.y) * direction;
        for (int i = 0; i < 30; ++i)
            point = origin + ((height(point.x, point.z) - origin.y) / direction.y) * direction;
        return point;
    };
    parallel_for(kSide, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            for (std::size_t column = 0; column < kSide; ++column) {
                const std::size_t i = row * kSide + column;
                const double x = static_cast<double>(column) + 0.5, y = static_cast<double>(row) + 0.5;
                const glm::dvec3 p = meet(x, y);
                layer.position[i] = glm::vec3(p);
                layer.footprint_u[i] = glm::vec3(meet(x + 0.5, y) - meet(x - 0.5, y));
                layer.footprint_v[i] = glm::vec3(meet(x, y + 0.5) - meet(x, y - 0.5));
                const double dx = (height(p.x + 1e-4, p.z) - height(p.x - 1e-4, p.z)) / 2e-4;
                const double dz = (height(p.x, p.z + 1e-4) - height(p.x, p.z - 1e-4)) / 2e-4;
                layer.shading_normal[i] = glm::vec3(glm::normalize(glm::dvec3(-dx, 1, -dz)));
            }
        }
    });
    return layer;
}

void coverage(benchmark::State& bench) {
    const double depth = static_cast<double>(bench.range(1));
    scene::FrameScene scene;
    scene.state = sea(static_cast<int>(bench.range(0)));
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(*scene.state.water).mesh(0));
    const rays::RayScene rays(scene);
    const view::ReceiverLayer layer = floor_layer(scene.state, depth);
    double beams_s = 0, pyramid_s = 0, coverage_s = 0, mean = 0;
    QueryCounts all;
    for (auto _ : bench) {
        FrameStats stats;
        const double before = cpu_seconds();
        auto sheets = light::water_beams<float>(scene, rays, {0, light::Event::transmission}, 1, stats);
        const double traced = cpu_seconds();
        const SheetCoverage<float> sheet(scene, rays, std::move(sheets.front()),
                                         static_cast<float>(1.3 * depth + 1));
        const double built = cpu_seconds();
        const LayerTiles tiles(layer, scene.state.clip);
        std::vector<QueryCounts> counts(tiles.count());
        std::vector<double> sums(tiles.count());
        parallel_for(tiles.count(), 4, [&](std::size_t begin, std::size_t end) {
            std::vector<glm::vec3> irradiance;
            for (std::size_t tile = begin; tile < end; ++tile) {
                for (const ReceiverGroup& group : tiles.groups(tile)) {
                    irradiance.assign(group.pixels.size(), glm::vec3(0));
                    sheet.add(group.receivers, group.object, irradiance, counts[tile]);
                    for (const glm::vec3& e : irradiance) sums[tile] += static_cast<double>(e.y);
                }
            }
        });
        const double done = cpu_seconds();
        beams_s += traced - before;
        pyramid_s += built - traced;
        coverage_s += done - built;
        mean = 0;
        for (const double s : sums) mean += s / static_cast<double>(layer.pixels());
        all = QueryCounts();
        for (const QueryCounts& c : counts) all.add(c);
    }
    const double n = static_cast<double>(bench.iterations());
    bench.counters["triangles_M"] = static_cast<double>(scene.water->mesh.triangles.size()) * 1e-6;
    bench.counters["beams_cpu_s"] = beams_s / n;
    bench.counters["pyramid_cpu_s"] = pyramid_s / n;
    bench.counters["coverage_cpu_s"] = coverage_s / n;
    bench.counters["mean_E"] = mean;
    bench.counters["clusters_a_tile"] = static_cast<double>(all.clusters) / (kSide * kSide / 64.0);
}
BENCHMARK(coverage)
    ->Args({512, 2})
    ->Args({1024, 2})
    ->Args({2048, 2})
    ->Args({4096, 2})
    ->Args({512, 8})
    ->Args({1024, 8})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
