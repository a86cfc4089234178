#include "light/landing.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "base/large_pages.h"
#include "base/parallel.h"
#include "light/grid_blocks.h"
#include "light/ray_batch.h"

namespace dapple::light {

Landings land(const BeamMesh& mesh, const rays::RayScene& rays) {
    Landings landings;
    resize_large(landings.depth, mesh.vertices());
    resize_large(landings.normal, mesh.vertices());
    const GridBlocks blocks(mesh.rows, mesh.columns);
    std::vector<std::size_t> landed(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        RayBatch batch;
        std::array<rays::Hit, RayBatch::kMost> hits;
        const auto trace = [&](std::size_t& count) {
            rays.intersect_objects(batch.rays(), std::span(hits).first(batch.rays().size()));
            for (std::size_t k = 0; k < batch.rays().size(); ++k) {
                if (hits[k].primitive == rays::kNoHit) continue;
                const std::size_t i = batch.vertices()[k];
                const glm::vec3 normal = glm::normalize(hits[k].normal);
                landings.depth[i] = mesh.start[i] + hits[k].distance;
                landings.normal[i] = glm::dot(normal, batch.rays()[k].direction) < 0 ? normal : -normal;
                count += mesh.flux[i] > 0 ? 1 : 0;
            }
            batch.clear();
        };
        for (std::size_t band = begin; band < end; ++band) {
            const auto [first, last] = blocks.band_range(band);
            std::fill_n(landings.depth.begin() + first, last - first, std::numeric_limits<float>::infinity());
            std::fill_n(landings.normal.begin() + first, last - first, glm::vec3(0, 1, 0));
            blocks.visit_band(band, [&](std::size_t i) {
                if (!mesh.lit(i)) return;
                rays::Ray& ray = batch.add(i);
                // From the surface: depths before it may be negative, distances not.
                ray.origin = mesh.origin[i] + mesh.start[i] * mesh.slope[i];
                ray.direction = mesh.slope[i];
                if (batch.full()) trace(landed[band]);
            });
            trace(landed[band]);
        }
    });
    landings.count = std::accumulate(landed.begin(), landed.end(), std::size_t{0});
    return landings;
}

}  // namespace dapple::light
