// coverage: what sliced_beams costs by itself: beams, pyramid and coverage of receivers on a curved
// and sloped floor, seen in perspective, under 24 waves, without shadow rays. Arguments: cells along x, depth
// of the floor [m], side of the picture [pixels]; 1 m down it is seen at grazing angles up to the horizon,
// above which a quarter of the pixels have no receiver. level_floor: a 512^2 level floor 2 m down with all
// that it needs, and its L1 distance from the light under a mesh of 4096^2 cells; waves of 0.25 to 3 m,
// elsewhere of 0.15 to 1.2 m. cpu_s is process CPU time of all threads.
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
#include "spiral_sea.h"
#include "view/camera.h"

namespace {

using namespace dapple;
using methods::sliced_beams::LayerTiles;
using methods::sliced_beams::QueryCounts;
using methods::sliced_beams::ReceiverGroup;
using methods::sliced_beams::SheetCoverage;

scene::FrameState sea(int cells, double shortest, double longest, int side = 512) {
    scene::FrameState state;
    state.clip.width = state.clip.height = side;
    state.clip.samples = 1;
    scene::Water& water = state.water.emplace();
    water.extent.size = {12, 12};
    water.mesh_cells = cells;
    bench::add_waves(water, shortest, longest, 0.0032);
    scene::Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.5, -0.8660254, 0));
    sun.angular_diameter = 0;
    state.lights.push_back(sun);
    state.camera.position = {0, -0.3, 2.2};
    state.camera.field_of_view = 1.0;
    return state;
}

/// Where a camera's rays meet the floor y = -depth (1 + 0.1 sin x cos z + 0.05 x), by fixed-point steps; none
/// where they look up, past the steps' reach (nearly level, or far off), or where the floor has left the
/// water.
view::ReceiverLayer floor_layer(const scene::FrameState& state, double depth) {
    scene::Camera camera = state.camera;
    camera.target = {0, -depth, 0};
    const int side = state.clip.width;
    const view::Camera view(camera, side, side);
    view::ReceiverLayer layer;
    layer.width = layer.height = side;
    layer.flags.assign(layer.pixels(), 0);
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
    const auto rows = static_cast<std::size_t>(side);
    parallel_for(rows, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            for (std::size_t column = 0; column < rows; ++column) {
                const std::size_t i = row * rows + column;
                const double x = static_cast<double>(column) + 0.5, y = static_cast<double>(row) + 0.5;
                glm::dvec3 origin, direction;
                view.ray({x, y}, origin, direction);
                if (direction.y > -0.02) continue;
                const glm::dvec3 p = meet(x, y);
                const double off = glm::distance(p, origin + glm::dot(p - origin, direction) * direction);
                if (!(glm::distance(p, origin) < 20) || off > 1e-3 || p.y > 0.0) continue;
                layer.flags[i] = view::kReceiver | view::kInWater;
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

/// The irradiance of a layer, and what it cost beside tracing and sorting the beams.
std::vector<glm::vec3> irradiance_of(const SheetCoverage<float>& sheet, const view::ReceiverLayer& layer,
                                     const scene::Clip& clip, QueryCounts& all) {
    const LayerTiles tiles(layer, clip);
    std::vector<QueryCounts> counts(tiles.count());
    std::vector<glm::vec3> result(layer.pixels(), glm::vec3(0));
    parallel_for(tiles.count(), 4, [&](std::size_t begin, std::size_t end) {
        std::vector<glm::vec3> irradiance;
        for (std::size_t tile = begin; tile < end; ++tile) {
            for (const ReceiverGroup& group : tiles.groups(tile)) {
                irradiance.assign(group.pixels.size(), glm::vec3(0));
                sheet.add(group.receivers, group.object, irradiance, counts[tile]);
                for (std::size_t i = 0; i < irradiance.size(); ++i) result[group.pixels[i]] = irradiance[i];
            }
        }
    });
    all = QueryCounts();
    for (const QueryCounts& c : counts) all.add(c);
    return result;
}

void coverage(benchmark::State& bench) {
    const double depth = static_cast<double>(bench.range(1));
    scene::FrameScene scene;
    scene.state = sea(static_cast<int>(bench.range(0)), 0.15, 1.2, static_cast<int>(bench.range(2)));
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(*scene.state.water).mesh(0));
    const rays::RayScene rays(scene);
    const view::ReceiverLayer layer = floor_layer(scene.state, depth);
    float deepest = 0;
    std::size_t receivers = 0;
    for (std::size_t i = 0; i < layer.pixels(); ++i) {
        if (layer.flags[i] == 0) continue;
        deepest = std::max(deepest, -layer.position[i].y);
        ++receivers;
    }
    double beams_s = 0, pyramid_s = 0, coverage_s = 0, mean = 0;
    QueryCounts all;
    for (auto _ : bench) {
        FrameStats stats;
        const double before = cpu_seconds();
        auto sheets = light::water_beams<float>(scene, rays, {0, light::Event::transmission}, 1, stats);
        const double traced = cpu_seconds();
        const SheetCoverage<float> sheet(scene, rays, std::move(sheets.front()), 1.3f * deepest + 1);
        const double built = cpu_seconds();
        const std::vector<glm::vec3> irradiance = irradiance_of(sheet, layer, scene.state.clip, all);
        const double done = cpu_seconds();
        beams_s += traced - before;
        pyramid_s += built - traced;
        coverage_s += done - built;
        mean = 0;
        for (const glm::vec3& e : irradiance)
            mean += static_cast<double>(e.y) / static_cast<double>(layer.pixels());
    }
    const double n = static_cast<double>(bench.iterations());
    bench.counters["triangles_M"] = static_cast<double>(scene.water->mesh.triangles.size()) * 1e-6;
    bench.counters["beams_cpu_s"] = beams_s / n;
    bench.counters["pyramid_cpu_s"] = pyramid_s / n;
    bench.counters["coverage_cpu_s"] = coverage_s / n;
    bench.counters["mean_E"] = mean;
    bench.counters["receivers"] = static_cast<double>(receivers);
    bench.counters["clusters_a_tile"] =
        static_cast<double>(all.clusters) / (static_cast<double>(layer.pixels()) / 64);
}
BENCHMARK(coverage)
    ->Args({512, 2, 1024})
    ->Args({1024, 2, 1024})
    ->Args({2048, 2, 1024})
    ->Args({4096, 2, 1024})
    ->Args({1024, 1, 1024})
    ->Args({1024, 4, 1024})
    ->Args({1024, 2, 256})
    ->Args({1024, 2, 512})
    ->Args({1024, 2, 2048})
    ->Args({512, 8, 1024})
    ->Args({1024, 8, 1024})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// 512^2 pixels over the middle 4 m x 4 m of a level floor 2 m down.
view::ReceiverLayer level_layer() {
    constexpr int kPixels = 512;
    constexpr float kPixel = 4.0f / kPixels;
    view::ReceiverLayer layer;
    layer.width = layer.height = kPixels;
    layer.flags.assign(layer.pixels(), view::kReceiver | view::kInWater);
    layer.object.assign(layer.pixels(), 0);
    layer.footprint_u.assign(layer.pixels(), {kPixel, 0, 0});
    layer.footprint_v.assign(layer.pixels(), {0, 0, kPixel});
    layer.shading_normal.assign(layer.pixels(), {0, 1, 0});
    for (int row = 0; row < kPixels; ++row)
        for (int column = 0; column < kPixels; ++column)
            layer.position.emplace_back((static_cast<float>(column) + 0.5f) * kPixel - 2, -2,
                                        (static_cast<float>(row) + 0.5f) * kPixel - 2);
    return layer;
}

struct Measured {
    std::vector<glm::vec3> irradiance;
    double surface_s = 0, ray_scene_s = 0, beams_s = 0, coverage_s = 0;  ///< CPU
};

/// Everything of a frame but the camera's side, the light on a level floor.
Measured light_level_floor(int cells, const view::ReceiverLayer& layer) {
    Measured measured;
    FrameStats stats;
    scene::FrameScene scene;
    scene.state = sea(cells, 0.25, 3);
    double before = cpu_seconds();
    const auto lap = [&] {
        const double now = cpu_seconds(), taken = now - before;
        before = now;
        return taken;
    };
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(*scene.state.water).mesh(0));
    measured.surface_s = lap();
    const rays::RayScene rays(scene);
    measured.ray_scene_s = lap();
    auto sheets = light::water_beams<float>(scene, rays, {0, light::Event::transmission}, 1, stats);
    const SheetCoverage<float> sheet(scene, rays, std::move(sheets.front()), 3.0f);
    measured.beams_s = lap();
    QueryCounts counts;
    measured.irradiance = irradiance_of(sheet, layer, scene.state.clip, counts);
    measured.coverage_s = lap();
    return measured;
}

void level_floor(benchmark::State& bench) {
    const view::ReceiverLayer layer = level_layer();
    static const std::vector<glm::vec3> finest = light_level_floor(4096, layer).irradiance;
    Measured sum, last;
    for (auto _ : bench) {
        last = light_level_floor(static_cast<int>(bench.range(0)), layer);
        sum.surface_s += last.surface_s;
        sum.ray_scene_s += last.ray_scene_s;
        sum.beams_s += last.beams_s;
        sum.coverage_s += last.coverage_s;
    }
    double difference = 0, light = 0;
    for (std::size_t i = 0; i < finest.size(); ++i) {
        difference += static_cast<double>(std::abs(last.irradiance[i].y - finest[i].y));
        light += static_cast<double>(finest[i].y);
    }
    const double n = static_cast<double>(bench.iterations());
    bench.counters["surface_cpu_s"] = sum.surface_s / n;
    bench.counters["ray_scene_cpu_s"] = sum.ray_scene_s / n;
    bench.counters["beams_cpu_s"] = sum.beams_s / n;
    bench.counters["coverage_cpu_s"] = sum.coverage_s / n;
    bench.counters["all_cpu_s"] = (sum.surface_s + sum.ray_scene_s + sum.beams_s + sum.coverage_s) / n;
    bench.counters["L1_percent"] = 100 * difference / light;
}
BENCHMARK(level_floor)->Arg(512)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
