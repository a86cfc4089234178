#include "light/map_plan.h"

#include <algorithm>
#include <cmath>

#include "optics/optics.h"

namespace dapple::light {
namespace {

/// How far the light throws points of the surface off their rest position, m, along x and z.
glm::dvec2 reach(const MapPlan& plan, const scene::Extent& extent, double displacement) {
    glm::dvec2 result(displacement);
    for (const double height : {-plan.height_bound, plan.height_bound}) {
        const double w = 1 - plan.inverse_height * height;
        if (w <= 0) return glm::dvec2(HUGE_VAL);
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec2 edge = extent.center + side * 0.5 * extent.size;
            const glm::dvec2 moved = (edge + side * displacement - plan.shear * height) / w;
            result = glm::max(result, side * (moved - edge));
        }
    }
    return result;
}

int border_texels(double reach, double texel, int inner, bool& capped) {
    const double wanted = reach > 0 ? std::ceil(reach / texel) : 0;
    const int most = inner / 2;
    if (wanted <= most) return static_cast<int>(wanted);
    capped = true;
    return most;
}

}  // namespace

MapPlan plan_map(const scene::FrameScene& scene, int light_index, int resolution) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
    const scene::Extent& extent = scene.state.water->extent;
    MapPlan plan;
    if (light.type == scene::LightType::sun) {
        plan.lit = light.direction.y < -kLowestSun;
        if (!plan.lit) return plan;
        plan.shear = glm::dvec2(light.direction.x, light.direction.z) / light.direction.y;
    } else {
        plan.lit = light.position.y != 0;
        if (!plan.lit) return plan;
        plan.from_below = light.position.y < 0;
        plan.inverse_height = 1 / light.position.y;
        plan.shear = glm::dvec2(light.position.x, light.position.z) * plan.inverse_height;
    }
    // A little room, so that a height at its bound is inside the depth range in float too.
    plan.height_bound = 1.001 * scene.water->height_bound + 1e-3;

    const double size = std::max(extent.size.x, extent.size.y) / resolution;
    const int inner_columns = std::max(1, static_cast<int>(std::lround(extent.size.x / size)));
    const int inner_rows = std::max(1, static_cast<int>(std::lround(extent.size.y / size)));
    plan.texel = extent.size / glm::dvec2(inner_columns, inner_rows);
    // Flat water needs no border, whatever the room above.
    glm::dvec2 thrown(0);
    if (scene.water->height_bound > 0 || scene.water->displacement_bound > 0)
        thrown = reach(plan, extent, scene.water->displacement_bound);
    const int border_x = border_texels(thrown.x, plan.texel.x, inner_columns, plan.capped);
    const int border_z = border_texels(thrown.y, plan.texel.y, inner_rows, plan.capped);
    plan.columns = inner_columns + 2 * border_x;
    plan.rows = inner_rows + 2 * border_z;
    plan.corner = extent.center - 0.5 * extent.size - glm::dvec2(border_x, border_z) * plan.texel;
    return plan;
}

glm::dvec3 mesh_axis(const scene::Light& light, bool from_below, Event event, double refractive_index) {
    const bool transmission = event == Event::transmission;
    if (light.type != scene::LightType::sun) return {0, transmission == from_below ? 1 : -1, 0};
    const glm::dvec3 up(0, 1, 0);
    glm::dvec3 axis = optics::f64::reflected_direction(light.direction, up);
    if (transmission) optics::f64::refracted_direction(light.direction, up, 1 / refractive_index, axis);
    return glm::normalize(axis);
}

}  // namespace dapple::light
