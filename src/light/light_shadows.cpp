#include "light/light_shadows.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/parallel.h"
#include "light/grid_blocks.h"

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
        std::vector<rays::Ray> way;
        std::vector<std::size_t> vertex;
        std::vector<std::uint8_t> occluded;
        for (std::size_t band = begin; band < end; ++band) {
            way.clear();
            vertex.clear();
            blocks.visit_band(band, [&](std::size_t i) {
                if (std::none_of(meshes.begin(), meshes.end(), [i](const BeamMesh& m) { return m.lit(i); }))
                    return;
                way.push_back(ray_to_light(scene, light, first.origin[i] + first.start[i] * first.slope[i]));
                vertex.push_back(i);
            });
            occluded.assign(way.size(), 0);
            rays.occluded_by_objects(way, occluded);
            for (std::size_t k = 0; k < vertex.size(); ++k) {
                if (!occluded[k]) continue;
                bool carried = false;
                for (BeamMesh& mesh : meshes) {
                    carried = carried || mesh.flux[vertex[k]] > 0;
                    mesh.flux[vertex[k]] = 0;
                    if (mesh.valid[vertex[k]] != 0) mesh.valid[vertex[k]] = BeamMesh::kShadowed;
                }
                shadowed[band] += carried ? 1 : 0;
            }
        }
    });
    return std::accumulate(shadowed.begin(), shadowed.end(), std::size_t{0});
}

}  // namespace dapple::light
