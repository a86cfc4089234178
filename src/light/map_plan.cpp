#include "light/map_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
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

/// Texels of a map along x or z.
struct MapAxis {
    double texel = 0;  ///< m
    int inner = 0;     ///< texels that fill the extent
    int border = 0;    ///< on either side of these
    bool capped = false;
};

/// Along an axis on which `wanted` texels should fill the extent, m, and light is thrown off by `thrown` m.
/// Where a low sun throws it farther than the map is wide, texels are widened by whole factors, so that the
/// border still fits into a map of twice those wanted: seen from such a sun they stay narrow.
MapAxis plan_axis(double extent, double wanted, double thrown) {
    MapAxis axis;
    for (double factor = 1; axis.inner != 1 && (factor == 1 || axis.capped); ++factor) {
        axis.inner = static_cast<int>(glm::max(1.0, std::round(wanted / factor)));
        axis.texel = extent / axis.inner;
        axis.capped = false;
        axis.border = border_texels(thrown, axis.texel, 2 * wanted - axis.inner, axis.capped);
    }
    return axis;
}

}  // namespace

double MapPlan::share(int column, int row) const {
    if (!weighted()) return 1;
    const std::size_t x = static_cast<std::size_t>(column), z = static_cast<std::size_t>(row);
    return shares.outer_x[x] * shares.outer_z[z] - shares.inner_x[x] * shares.inner_z[z];
}

void check_map_size(std::int64_t columns, std::int64_t rows) {
    constexpr std::int64_t kMost = 1 << 16;
    if (columns > kMost || rows > kMost)
        throw Error(ExitCode::timeline_invalid,
                    "a caustic map of " + std::to_string(columns) + " x " + std::to_string(rows) +
                        " texels cannot be made; take fewer photons a side or more cascades");
}

int border_texels(double thrown, double texel, double inner, bool& capped) {
    const double wanted = thrown > 0 ? std::ceil(thrown / texel) : 0;
    const double most = std::floor(inner / 2);
    if (wanted > most) capped = true;
    return static_cast<int>(std::min(wanted, most));
}

glm::dvec2 thrown_off(const MapPlan& plan, const scene::FrameScene& scene) {
    if (!(scene.water->height_bound > 0 || scene.water->displacement_bound > 0)) return glm::dvec2(0);
    return reach(plan, scene.state.water->extent, scene.water->displacement_bound);
}

MapPlan plan_projection(const scene::FrameScene& scene, int light_index) {
    const scene::Light& light = scene.state.lights[static_cast<std::size_t>(light_index)];
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
    return plan;
}

MapPlan plan_map(const scene::FrameScene& scene, int light_index, double resolution) {
    const scene::Extent& extent = scene.state.water->extent;
    MapPlan plan = plan_projection(scene, light_index);
    if (!plan.lit) return plan;
    const double size = std::max(extent.size.x, extent.size.y) / resolution;
    const glm::dvec2 inner = glm::max(glm::dvec2(1), glm::round(extent.size / size));
    check_map_size(std::llround(inner.x), std::llround(inner.y));
    const glm::dvec2 thrown = thrown_off(plan, scene);
    const MapAxis x = plan_axis(extent.size.x, inner.x, thrown.x),
                  z = plan_axis(extent.size.y, inner.y, thrown.y);
    plan.capped = x.capped || z.capped;
    plan.texel = glm::dmat2(x.texel, 0, 0, z.texel);
    plan.columns = x.inner + 2 * x.border;
    plan.rows = z.inner + 2 * z.border;
    check_map_size(plan.columns, plan.rows);
    plan.anchor = extent.center - 0.5 * extent.size - glm::dvec2(x.border * x.texel, z.border * z.texel);
    plan.parts = {{0, 0, plan.columns, plan.rows}};
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
