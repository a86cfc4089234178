#pragma once
#include <cmath>
#include <vector>

#include "light/water_beams.h"
#include "methods/adaptive_beams/beam_set.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

/// Beams to draw without a light view: every triangle of the water mesh is one.
namespace dapple::test {

/// Sheets of light 0 as beams that end on the level floor at -depth m, object 0.
inline std::vector<methods::adaptive_beams::BeamSet> drawn_sheets(
    const scene::FrameScene& scene, const rays::RayScene& rays, double depth,
    light::Event event = light::Event::transmission) {
    std::vector<methods::adaptive_beams::BeamSet> sets;
    FrameStats stats;
    for (const auto& sheet : light::water_beams<double>(scene, rays, {0, event}, 1, stats)) {
        methods::adaptive_beams::BeamSet set;
        set.name = sheet.name;
        set.in_water = sheet.in_water();
        set.world_from_mesh = sheet.world_from_mesh;
        const glm::dvec3 up = glm::transpose(sheet.world_from_mesh) * glm::dvec3(0, 1, 0);
        for (std::size_t i = 0; i < sheet.rays.size(); ++i) {
            const auto& ray = sheet.rays[i];
            const double height = ray.a * up.x + ray.b * up.y;
            const double slope = ray.slope_a * up.x + ray.slope_b * up.y + up.z;
            const double end = slope < 0 ? (-depth - height) / slope : 0;
            set.vertices.push_back({static_cast<float>(ray.a), static_cast<float>(ray.b),
                                    static_cast<float>(ray.slope_a), static_cast<float>(ray.slope_b),
                                    static_cast<float>(sheet.start[i]),
                                    static_cast<float>(std::max(end, sheet.start[i]))});
        }
        for (std::size_t i = 0; i < sheet.flux.size(); ++i) {
            if (!(sheet.flux[i] > 0)) continue;
            set.triangles.push_back(scene.water->mesh.triangles[i]);
            set.flux.emplace_back(sheet.flux[i] * sheet.color);
            set.ends_on.push_back(0);
        }
        sets.push_back(std::move(set));
    }
    return sets;
}

}  // namespace dapple::test
