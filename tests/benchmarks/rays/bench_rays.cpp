// What Embree traces on this machine under the settings of dapple (avx2, robust, packets of 8 with the
// coherent flag), bare and behind rays::RayScene, and what a camera layer costs on top. items_per_second:
// rays, of all threads that parallel_for uses; layers: pixels.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "rays/ray_scene.h"
#include "rays/shape_mesh.h"
#include "view/view_scene.h"  // of the tests

namespace {

using namespace dapple;

constexpr int kSide = 1024;
constexpr std::size_t kRays = std::size_t{kSide} * kSide;
constexpr std::size_t kBatch = 4096;

/// Rays in tiles of 4 x 4, as the light pass sends them.
template <typename MakeRay>
std::vector<rays::Ray> tiled(const MakeRay& make) {
    std::vector<rays::Ray> result;
    result.reserve(kRays);
    for (int tile_y = 0; tile_y < kSide; tile_y += 4) {
        for (int tile_x = 0; tile_x < kSide; tile_x += 4) {
            for (int i = 0; i < 16; ++i) {
                const int x = tile_x + i % 4;
                const int y = tile_y + i / 4;
                result.push_back(make((x + 0.5) / kSide, (y + 0.5) / kSide));
            }
        }
    }
    return result;
}

/// From the water down, bent like light below waves.
std::vector<rays::Ray> refracted_rays() {
    return tiled([](double u, double v) {
        const double x = 10 * (u - 0.5);
        const double z = 10 * (v - 0.5);
        const glm::dvec3 direction(0.2 + 0.1 * std::sin(5 * x), -1, 0.1 * std::cos(7 * z));
        return rays::Ray{glm::vec3(x, 0, z), 0, glm::vec3(normalize(direction))};
    });
}

/// From a camera 2 m under the middle of the water, upwards.
std::vector<rays::Ray> camera_rays() {
    return tiled([](double u, double v) {
        return rays::Ray{glm::vec3(0, -2, 0), 0,
                         glm::vec3(normalize(glm::dvec3(3 * (u - 0.5), 1, 3 * (v - 0.5))))};
    });
}

test::ViewScene floor_and_boxes() {
    test::ViewScene scene(960, 540);
    scene.add_floor(-2, 12);
    for (const double x : {-2.0, 2.0}) {
        for (const double z : {-2.0, 2.0}) scene.add(scene::Shape::box, {x, -1.5, z});
    }
    return scene;
}

test::ViewScene fine_water() {
    test::ViewScene scene(960, 540);
    scene.fill(test::wavy_water(10, kSide), 10);  // 2.1 million triangles
    return scene;
}

void bare_embree(benchmark::State& state) {
    RTCDevice device = rtcNewDevice("isa=avx2");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const test::ViewScene objects = floor_and_boxes();
    for (const scene::Object& object : objects.frame.state.objects) {
        const scene::TriangleMesh mesh =
            object.shape == scene::Shape::box ? rays::box_mesh(object.size) : rays::plane_mesh(object.size);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<glm::vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                    mesh.positions.size()));
        auto* triangles = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangles.size()));
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            positions[i] = glm::vec3(mesh.positions[i] + object.transform.position);
        }
        std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);

    const std::vector<rays::Ray> rays = refracted_rays();
    std::vector<RTCRayHit8> fresh(kRays / 8);
    for (std::size_t i = 0; i < kRays; ++i) {
        RTCRay8& ray = fresh[i / 8].ray;
        const std::size_t lane = i % 8;
        ray.org_x[lane] = rays[i].origin.x;
        ray.org_y[lane] = rays[i].origin.y;
        ray.org_z[lane] = rays[i].origin.z;
        ray.dir_x[lane] = rays[i].direction.x;
        ray.dir_y[lane] = rays[i].direction.y;
        ray.dir_z[lane] = rays[i].direction.z;
        ray.tnear[lane] = 0;
        ray.tfar[lane] = rays[i].far;
        ray.mask[lane] = ~0u;
        ray.time[lane] = 0;
        ray.flags[lane] = 0;
        ray.id[lane] = 0;
        fresh[i / 8].hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    for ([[maybe_unused]] auto _ : state) {
        parallel_for(fresh.size(), kBatch / 8, [&](std::size_t begin, std::size_t end) {
            alignas(32) const int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
            for (std::size_t i = begin; i < end; ++i) {
                RTCRayHit8 packet = fresh[i];
                rtcIntersect8(valid, scene, &context, &packet);
                benchmark::DoNotOptimize(packet.ray.tfar[0]);
            }
        });
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(kRays) * state.iterations());
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
BENCHMARK(bare_embree)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

enum class Query { objects, water, occlusion };

void ray_scene(benchmark::State& state, const test::ViewScene& view, const std::vector<rays::Ray>& rays,
               Query query) {
    const rays::RayScene scene(view.frame);
    std::vector<rays::Hit> hits(kRays);
    std::vector<std::uint8_t> occluded(kRays);
    for ([[maybe_unused]] auto _ : state) {
        parallel_for(kRays, kBatch, [&](std::size_t begin, std::size_t end) {
            const std::span<const rays::Ray> batch(rays.data() + begin, end - begin);
            const std::span<rays::Hit> found(hits.data() + begin, end - begin);
            if (query == Query::objects) scene.intersect_objects(batch, found);
            if (query == Query::water) scene.intersect_water(batch, found);
            if (query == Query::occlusion) {
                scene.occluded_by_objects(batch, std::span(occluded.data() + begin, end - begin));
            }
        });
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(kRays) * state.iterations());
}
BENCHMARK_CAPTURE(ray_scene, floor_and_boxes, floor_and_boxes(), refracted_rays(), Query::objects)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(ray_scene, occlusion, floor_and_boxes(), refracted_rays(), Query::occlusion)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(ray_scene, water_2m_triangles, fine_water(), camera_rays(), Query::water)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

void build_water(benchmark::State& state) {
    const test::ViewScene view = fine_water();
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(rays::RayScene(view.frame).has_objects());
}
BENCHMARK(build_water)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

/// A pool seen from under water: half of the picture is the surface from below.
void camera_layer(benchmark::State& state) {
    test::ViewScene view = floor_and_boxes();
    view.fill(test::wavy_water(10, kSide), 10, scene::ExtentKind::pool);
    view.look({0, -1, 4.5}, {0, -0.9, 0}, 0.9);
    const rays::RayScene rays(view.frame);
    const int branch = static_cast<int>(state.range(0));
    for ([[maybe_unused]] auto _ : state) {
        view::LayerCounts counts;
        benchmark::DoNotOptimize(view::trace_layer(view.frame, rays, {0, branch}, counts).flags.data());
    }
    state.SetItemsProcessed(960 * 540 * state.iterations());
}
BENCHMARK(camera_layer)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace
