// make: the light side of adaptive beams, by its own passes: grids of 16 cells a side with 0 to 5 levels, and
// regular ones of 16 to 256. Arguments: scene (0: waves over a pool of 6 m; 1: a ball of glass over flat
// water; 2: a ball of glass with 2000 dents), cells, levels. `beams`, on all legs; `carried`: share of the
// light that meets the body and is not lost at silhouettes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "methods/adaptive_beams/make_beams.h"
#include "ocean/water_surface.h"
#include "spiral_sea.h"

namespace {

using namespace dapple;

constexpr double kPi = 3.141592653589793;

/// A sphere of 0.5 m, 512 by 256, with dents of `depth` of its radius.
scene::TriangleMesh dented_ball(double depth) {
    constexpr int kColumns = 512, kRows = 256;
    scene::TriangleMesh mesh;
    const auto point = [&](double u, double v) {
        const double a = 2 * kPi * u, b = kPi * v;
        const double radius =
            0.5 * (1 + depth * std::cos(64 * a) * std::cos(64 * b) * std::pow(std::sin(b), 2));
        return radius * glm::dvec3(std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a));
    };
    for (int row = 0; row <= kRows; ++row)
        for (int column = 0; column <= kColumns; ++column) {
            const double u = static_cast<double>(column) / kColumns, v = static_cast<double>(row) / kRows;
            mesh.positions.push_back(point(u, v));
            const double step = 1e-5;
            const glm::dvec3 normal =
                glm::cross(point(u, v + step) - point(u, v - step), point(u + step, v) - point(u - step, v));
            const glm::dvec3 out = row == 0 || row == kRows ? mesh.positions.back() : normal;
            mesh.normals.push_back(glm::normalize(glm::dot(out, mesh.positions.back()) < 0 ? -out : out));
        }
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const auto at = [&](int r, int c) { return static_cast<unsigned>(r * (kColumns + 1) + c); };
            if (row > 0)
                mesh.triangles.emplace_back(at(row, column), at(row, column + 1), at(row + 1, column));
            if (row < kRows - 1)
                mesh.triangles.emplace_back(at(row, column + 1), at(row + 1, column + 1),
                                            at(row + 1, column));
        }
    return mesh;
}

struct Scene {
    std::unique_ptr<scene::FrameScene> frame = std::make_unique<scene::FrameScene>();
    std::vector<light::Chain> chains;
};

Scene scene_of(int number) {
    Scene made;
    scene::FrameScene& frame = *made.frame;
    frame.state.clip.width = 960;
    frame.state.clip.height = 540;
    frame.state.camera.position = {0, 0.5, 6};
    frame.state.camera.target = {0, -1, 0};
    scene::Light sun;
    sun.direction = glm::normalize(glm::dvec3(0.4, -0.9, 0.1));
    sun.angular_diameter = 0;
    frame.state.lights.push_back(sun);
    scene::Object floor;
    floor.size = {40, 1, 40};
    floor.transform.position = {0, -2, 0};
    frame.state.objects.push_back(floor);
    using light::Event;
    if (number < 2) {
        scene::Water& water = frame.state.water.emplace();
        water.extent.size = {6, 6};
        water.mesh_cells = number == 0 ? 1024 : 64;
        if (number == 0) bench::add_waves(water, 0.3, 1.5, 0.0032);
        frame.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    }
    if (number == 0) {
        made.chains = {{0, Event::transmission}};
        return made;
    }
    scene::Object ball;
    ball.material.glass = true;
    ball.transform.position = {0, 1, 0};
    ball.shape = number == 1 ? scene::Shape::sphere : scene::Shape::mesh;
    frame.state.objects.push_back(ball);
    frame.object_meshes = {nullptr, nullptr};
    if (number == 2) frame.object_meshes[1] = std::make_shared<scene::TriangleMesh>(dented_ball(0.01));
    made.chains = {{0, Event::transmission, 1}, {0, Event::reflection, 1}};
    return made;
}

void make(benchmark::State& run) {
    const Scene scene = scene_of(static_cast<int>(run.range(0)));
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
