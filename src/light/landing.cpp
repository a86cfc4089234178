#include "light/landing.h"

#include <limits>
#include <numeric>

#include "base/large_pages.h"
#include "base/parallel.h"
#include "light/ray_group.h"
#include "rays/ray_lanes.h"

namespace dapple::light {
namespace {

/// Returns how many of the rays that carry light landed.
std::size_t land_group(const RayGroup& group, const BeamMesh& mesh, const rays::RayScene& rays,
                       Landings& landings) {
    rays::RayLanes eight;
    rays::HitLanes hits;
    eight.on = group.lit(mesh);
    if (lanes::any(eight.on)) {
        // From the surface: depths before it may be negative, distances not.
        eight.origin = group.start(mesh);
        eight.direction = group.of(mesh.slope);
        rays.intersect_objects(eight, hits);
    }
    const lanes::Vectors3 normal = normalized(hits.normal);
    group.put(landings.depth, hits.hit ? group.of(mesh.start) + hits.distance
                                       : lanes::splat(std::numeric_limits<float>::infinity()));
    group.put(landings.normal, choose((dot(normal, eight.direction) < 0.0f) | ~hits.hit, normal, -normal));
    return static_cast<std::size_t>(__builtin_popcount(lanes::bits(hits.hit & (group.of(mesh.flux) > 0.0f))));
}

}  // namespace

Landings land(const BeamMesh& mesh, const rays::RayScene& rays) {
    Landings landings;
    land(mesh, rays, landings);
    return landings;
}

void land(const BeamMesh& mesh, const rays::RayScene& rays, Landings& landings) {
    renew_large(landings.depth, mesh.vertices());
    renew_large(landings.normal, mesh.vertices());
    const GridBlocks blocks(mesh.rows, mesh.columns);
    std::vector<std::size_t> landed(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band)
            blocks.visit_groups(band, [&](const GridBlocks::Group& group) {
                landed[band] += land_group(RayGroup(group, mesh), mesh, rays, landings);
            });
    });
    landings.count = std::accumulate(landed.begin(), landed.end(), std::size_t{0});
}

}  // namespace dapple::light
