#include "light/landing.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/parallel.h"
#include "light/grid_blocks.h"

namespace dapple::light {

Landings land(const BeamMesh& mesh, const rays::RayScene& rays) {
    Landings landings;
    landings.depth.resize(mesh.vertices());
    landings.normal.resize(mesh.vertices());
    const GridBlocks blocks(mesh.rows, mesh.columns);
    std::vector<std::size_t> landed(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<rays::Ray> beams;
        std::vector<rays::Hit> hits;
        std::vector<std::size_t> vertex;
        beams.reserve(blocks.band_size());
        vertex.reserve(blocks.band_size());
        for (std::size_t band = begin; band < end; ++band) {
            beams.clear();
            vertex.clear();
            const auto [first, last] = blocks.band_range(band);
            std::fill_n(landings.depth.begin() + first, last - first, std::numeric_limits<float>::infinity());
            std::fill_n(landings.normal.begin() + first, last - first, glm::vec3(0, 1, 0));
            blocks.visit_band(band, [&](std::size_t i) {
                if (!mesh.lit(i)) return;
                rays::Ray ray;
                // From the surface: depths before it may be negative, distances not.
                ray.origin = mesh.origin[i] + mesh.start[i] * mesh.slope[i];
                ray.direction = mesh.slope[i];
                beams.push_back(ray);
                vertex.push_back(i);
            });
            hits.resize(beams.size());
            rays.intersect_objects(beams, hits);
            for (std::size_t k = 0; k < vertex.size(); ++k) {
                if (hits[k].primitive == rays::kNoHit) continue;
                const glm::vec3 normal = glm::normalize(hits[k].normal);
                landings.depth[vertex[k]] = mesh.start[vertex[k]] + hits[k].distance;
                landings.normal[vertex[k]] = glm::dot(normal, beams[k].direction) < 0 ? normal : -normal;
                landed[band] += mesh.flux[vertex[k]] > 0 ? 1 : 0;
            }
        }
    });
    landings.count = std::accumulate(landed.begin(), landed.end(), std::size_t{0});
    return landings;
}

}  // namespace dapple::light
