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

/// 32 W. All rays meet a line 1 m deep, and another 1 / `across` m deep; with 1 they meet in a point. They go
/// from one depth to another.
inline methods::adaptive_beams::BeamSet lens_of_beams(float across, float start = 0, float end = 3) {
    methods::adaptive_beams::BeamSet lens;
    lens.in_water = true;
    lens.world_from_mesh = glm::dmat3(glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0));
    for (int row = 0; row <= 4; ++row)
        for (int column = 0; column <= 4; ++column) {
            const float a = 0.1f * static_cast<float>(column - 2), b = 0.1f * static_cast<float>(row - 2);
            lens.vertices.push_back({a, b, -a, -across * b, start, end});
        }
    for (std::uint32_t row = 0; row < 4; ++row)
        for (std::uint32_t column = 0; column < 4; ++column) {
            const std::uint32_t i = 5 * row + column;
            lens.triangles.emplace_back(i, i + 5, i + 1);
            lens.triangles.emplace_back(i + 1, i + 5, i + 6);
        }
    lens.flux.assign(lens.triangles.size(), glm::vec3(1));
    lens.ends_on.assign(lens.triangles.size(), 0);
    return lens;
}

}  // namespace dapple::test
