#include "light/light_shadows.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "base/parallel.h"
#include "light/grid_blocks.h"
#include "light/ray_batch.h"

namespace dapple::light {

bool may_shadow(const scene::FrameScene& scene, const rays::RayScene& rays, const scene::Light& light) {
    if (!rays.has_objects()) return false;
    glm::vec3 lower, upper;
    rays.object_bounds(lower, upper);
    const double lowest = lower.y + scene.origin.y, highest = upper.y + scene.origin.y;
    const double bound = scene.water->height_bound;
    if (light.type == scene::LightType::sun) return highest > -bound;
    const double height = light.position.y;
    return highest > std::min(-bound, height) && lowest < std::max(bound, height);
}

rays::Ray ray_to_light(const scene::FrameScene& scene, const scene::Light& light, glm::vec3 surface_point) {
    rays::Ray ray;
    ray.origin = surface_point;
    if (light.type == scene::LightType::sun) {
        ray.direction = glm::vec3(-light.direction);
    } else {
        ray.direction = glm::vec3(light.position - scene.origin) - surface_point;
        ray.far = 1;
    }
    return ray;
}

std::size_t shadow_meshes(std::span<BeamMesh> meshes, const scene::FrameScene& scene,
                          const rays::RayScene& rays) {
    const BeamMesh& first = meshes.front();
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(first.light)];
    const GridBlocks blocks(first.rows, first.columns);
    std::vector<std::size_t> shadowed(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        RayBatch batch;
        std::array<std::uint8_t, RayBatch::kMost> occluded;
        const auto trace = [&](std::size_t& count) {
            const std::span<const std::size_t> vertices = batch.vertices();
            rays.occluded_by_objects(batch.rays(), std::span(occluded).first(vertices.size()));
            for (std::size_t k = 0; k < vertices.size(); ++k) {
                if (!occluded[k]) continue;
                bool carried = false;
                for (BeamMesh& mesh : meshes) {
                    carried = carried || mesh.flux[vertices[k]] > 0;
                    mesh.flux[vertices[k]] = 0;
                    if (mesh.valid[vertices[k]] != 0) mesh.valid[vertices[k]] = BeamMesh::kShadowed;
                }
                count += carried ? 1 : 0;
            }
            batch.clear();
        };
        for (std::size_t band = begin; band < end; ++band) {
            blocks.visit_band(band, [&](std::size_t i) {
                if (std::none_of(meshes.begin(), meshes.end(), [i](const BeamMesh& m) { return m.lit(i); }))
                    return;
                batch.add(i) = ray_to_light(scene, light, first.origin[i] + first.start[i] * first.slope[i]);
                if (batch.full()) trace(shadowed[band]);
            });
            trace(shadowed[band]);
        }
    });
    return std::accumulate(shadowed.begin(), shadowed.end(), std::size_t{0});
}

}  // namespace dapple::light
