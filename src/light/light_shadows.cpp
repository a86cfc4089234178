#include "light/light_shadows.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/parallel.h"
#include "light/ray_group.h"
#include "rays/ray_lanes.h"

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
    const rays::Ray from_origin = ray_to_light(scene, light, glm::vec3(0));
    const bool sun = light.type == scene::LightType::sun;
    const auto shadow = [&](const RayGroup& group) {
        rays::RayLanes eight;
        for (const BeamMesh& mesh : meshes) eight.on |= group.lit(mesh);
        if (!lanes::any(eight.on)) return 0;
        eight.origin = group.start(first);
        eight.direction = lanes::all(from_origin.direction);
        if (!sun) eight.direction = eight.direction - eight.origin;
        eight.far = lanes::splat(from_origin.far);
        const lanes::Flags occluded = rays.occluded_by_objects(eight);
        int count = 0;
        for (unsigned left = lanes::bits(occluded); left != 0; left &= left - 1) {
            const std::size_t i = group.vertex(static_cast<std::size_t>(__builtin_ctz(left)));
            bool carried = false;
            for (BeamMesh& mesh : meshes) {
                carried = carried || mesh.flux[i] > 0;
                mesh.flux[i] = 0;
                if (mesh.valid[i] != 0) mesh.valid[i] = BeamMesh::kShadowed;
            }
            count += carried ? 1 : 0;
        }
        return count;
    };
    const GridBlocks blocks(first.rows, first.columns);
    std::vector<int> shadowed(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band)
            blocks.visit_groups(band, [&](const GridBlocks::Group& group) {
                shadowed[band] += shadow(RayGroup(group, first));
            });
    });
    return std::accumulate(shadowed.begin(), shadowed.end(), std::size_t{0});
}

}  // namespace dapple::light
