// What rays through media cost: optical depths and density profiles of 10^5 rays through a cloud of 128^3
// voxels of which a third are empty, as a sun's light crosses it (neighbours in order) and at random.
// items_per_second: cells of the grid that the rays cross with density in them, of all threads; rays/s
// beside.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "base/hash.h"
#include "base/parallel.h"
#include "grids/density_grid.h"
#include "media/media.h"

namespace {

using namespace dapple;

constexpr std::size_t kRays = 100000;
constexpr std::size_t kTile = 500;
constexpr int kVoxels = 128;
constexpr double kVoxel = 0.02;  // m

/// A ball of waves: dense, thin and empty parts.
const scene::FrameScene& scene_with_cloud() {
    static const scene::FrameScene scene = [] {
        std::vector<float> values;
        for (int z = 0; z < kVoxels; ++z)
            for (int y = 0; y < kVoxels; ++y)
                for (int x = 0; x < kVoxels; ++x) {
                    const glm::vec3 p = (glm::vec3(x, y, z) + 0.5f) / (0.5f * kVoxels) - 1.0f;
                    const float waves =
                        std::sin(9 * p.x + 2 * std::sin(5 * p.y)) * std::sin(7 * p.z + 3 * p.x);
                    values.push_back(std::max(0.0f, 1.0f + 0.8f * waves - 1.2f * glm::dot(p, p)));
                }
        scene::FrameScene made;
        made.state.media.emplace_back();
        made.state.media[0].type = scene::MediumType::grid;
        made.medium_grids.push_back(
            grids::DensityGrid::from_values(glm::ivec3(-kVoxels / 2), glm::ivec3(kVoxels), values,
                                            glm::scale(glm::dmat4(1), glm::dvec3(kVoxel))));
        return made;
    }();
    return scene;
}

struct Ray {
    glm::dvec3 origin, direction;
};

std::vector<Ray> sun_rays() {
    std::vector<Ray> rays;
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
    const auto side = static_cast<int>(std::sqrt(kRays));
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k)
            rays.push_back({glm::dvec3(2.56 * (i + 0.5) / side - 1.28, 0, 2.56 * (k + 0.5) / side - 1.28) -
                                5.0 * direction,
                            direction});
    return rays;
}

std::vector<Ray> random_rays() {
    std::vector<Ray> rays;
    const auto roll = [](std::size_t i, std::uint32_t k) { return 2 * hash_uniform(1, 0, i, k) - 1; };
    for (std::size_t i = 0; i < kRays; ++i) {
        const glm::dvec3 direction = glm::normalize(glm::dvec3(roll(i, 0), roll(i, 1), roll(i, 2)));
        rays.push_back({glm::dvec3(roll(i, 3), roll(i, 4), roll(i, 5)) - 5.0 * direction, direction});
    }
    return rays;
}

template <class Body>
void run(benchmark::State& state, const std::vector<Ray>& rays, Body&& body) {
    const media::Media media(scene_with_cloud());
    std::size_t cells = 0;
    for (const Ray& ray : rays) cells += media.profile(ray.origin, ray.direction, 10, false).place.size();
    for (auto _ : state)
        parallel_for(rays.size(), kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(media, rays[i]);
        });
    const auto times = static_cast<std::int64_t>(state.iterations());
    state.SetItemsProcessed(times * static_cast<std::int64_t>(cells));
    state.counters["rays/s"] = benchmark::Counter(
        static_cast<double>(rays.size()) * static_cast<double>(times), benchmark::Counter::kIsRate);
}

void depth(const media::Media& media, const Ray& ray) {
    benchmark::DoNotOptimize(media.optical_depth(ray.origin, ray.direction, 10, false));
}
void profile(const media::Media& media, const Ray& ray) {
    benchmark::DoNotOptimize(media.profile(ray.origin, ray.direction, 10, false));
}

void sun_depth(benchmark::State& state) {
    run(state, sun_rays(), depth);
}
void random_depth(benchmark::State& state) {
    run(state, random_rays(), depth);
}
void sun_profile(benchmark::State& state) {
    run(state, sun_rays(), profile);
}
void building(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(media::Media(scene_with_cloud()));
}

BENCHMARK(sun_depth)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(random_depth)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(sun_profile)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(building)->Unit(benchmark::kMillisecond);

}  // namespace
