#include "ocean/lamp_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "ocean/grid_size.h"
#include "scene/area_light.h"

namespace dapple::ocean {
namespace {

/// Whether a spot's cone meets a segment, from `a` on by `along`, relative to the spot.
bool meets_segment(glm::dvec3 axis, double cos_cone, glm::dvec3 a, glm::dvec3 along) {
    // The cosine to the axis, (a + t along) . axis / |a + t along|, is largest at an end or where its
    // derivative is 0, which is linear in t.
    const double from = glm::dot(a, axis), grows = glm::dot(along, axis), mixed = glm::dot(a, along);
    const double turning = (from * mixed - grows * glm::dot(a, a)) /
                           (grows * mixed - from * glm::dot(along, along));  // NaN where it never turns
    return std::ranges::any_of(std::initializer_list<double>{0.0, turning, 1.0}, [&](double t) {
        if (!(t >= 0 && t <= 1)) return false;
        const glm::dvec3 to = a + t * along;
        return glm::dot(to, axis) >= cos_cone * glm::length(to);
    });
}

/// Whether some of the rest plane within the extent lies in a spot's cone.
bool reaches(const scene::Light& spot, const scene::Extent& extent) {
    const glm::dvec3 corner =
        glm::dvec3(extent.center.x - 0.5 * extent.size.x, 0, extent.center.y - 0.5 * extent.size.y) -
        spot.position;
    const glm::dvec3 x(extent.size.x, 0, 0), z(0, 0, extent.size.y);
    // What lies in the cone is convex: it holds where the axis meets the plane, if it does, or ends nowhere.
    const double way = corner.y / spot.direction.y;
    const glm::dvec3 hit = way * spot.direction - corner;
    if (way >= 0 && hit.x >= 0 && hit.x <= extent.size.x && hit.z >= 0 && hit.z <= extent.size.y) return true;
    const double cos_cone = std::cos(spot.cone_angle);
    const auto meets = [&](glm::dvec3 a, glm::dvec3 along) {
        return meets_segment(spot.direction, cos_cone, a, along);
    };
    return meets(corner, x) || meets(corner, z) || meets(corner + x, z) || meets(corner + z, x);
}

/// Least distance of the extent on the rest plane from an area light, of what lies before its plane, m;
/// infinite where nothing does.
double distance_before(const scene::Light& light, const scene::Extent& extent) {
    const auto before = [&](glm::dvec2 at) {
        return glm::dot(glm::dvec3(at.x, 0, at.y) - light.position, light.direction);
    };
    const glm::dvec2 foot(light.position.x, light.position.z);
    const glm::dvec2 off = glm::abs(foot - extent.center) - 0.5 * extent.size;
    if (off.x <= 0 && off.y <= 0 && before(foot) > 0) return std::abs(light.position.y);
    // Else at the border of what is left of the extent.
    std::vector<glm::dvec2> border;
    const std::array<glm::dvec2, 4> corners = {{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
    for (std::size_t i = 0; i < 4; ++i) {
        const glm::dvec2 a = extent.center + corners[i] * extent.size;
        const glm::dvec2 b = extent.center + corners[(i + 1) % 4] * extent.size;
        const double at_a = before(a), at_b = before(b);
        if (at_a > 0) border.push_back(a);
        if ((at_a > 0) != (at_b > 0)) border.push_back(glm::mix(a, b, at_a / (at_a - at_b)));
    }
    double nearest = INFINITY;
    for (std::size_t i = 0; i < border.size(); ++i) {
        const glm::dvec2 a = border[i], along = border[(i + 1) % border.size()] - a;
        const double length2 = glm::dot(along, along);
        const double at = length2 > 0 ? std::clamp(glm::dot(foot - a, along) / length2, 0.0, 1.0) : 0;
        nearest = std::min(nearest, glm::distance(foot, a + at * along));
    }
    return std::hypot(nearest, light.position.y);
}

/// Least distance of the extent on the rest plane from a lamp, within its cone or on its side, m; infinite
/// where no light gets there.
double distance_to(const scene::Light& lamp, const scene::Extent& extent) {
    if (scene::is_area(lamp)) return distance_before(lamp, extent);
    const glm::dvec2 beside = glm::max(
        glm::abs(glm::dvec2(lamp.position.x, lamp.position.z) - extent.center) - 0.5 * extent.size, 0.0);
    const double height = lamp.position.y;
    const double nearest = std::hypot(height, beside.x, beside.y);
    if (lamp.type != scene::LightType::spot) return nearest;
    if (!reaches(lamp, extent)) return INFINITY;
    // Along the cone's steepest line.
    const double down = height > 0 ? -lamp.direction.y : lamp.direction.y;
    const double angle = std::max(0.0, std::acos(std::clamp(down, -1.0, 1.0)) - lamp.cone_angle);
    return std::max(nearest, std::abs(height) / std::max(std::cos(angle), 0.0));
}

/// Widest beams that serve a lamp, m.
double widest_beams(const scene::Light& lamp, const scene::Extent& extent) {
    if (lamp.type == scene::LightType::sun || lamp.intensity == glm::dvec3(0)) return INFINITY;
    const double distance =
        std::max(distance_to(lamp, extent), kLeastDistance * std::min(extent.size.x, extent.size.y));
    const double along = distance / kBeamsAlongDistance;
    if (lamp.type != scene::LightType::spot) return along;
    const double across = 2 * distance * std::tan(lamp.cone_angle);
    return std::min(along, across / (lamp.texture.empty() ? kBeamsAcrossSpot : kBeamsAcrossPicture));
}

}  // namespace

scene::FrameState with_mesh_for_lamps(scene::FrameState state) {
    if (!state.water || state.water->mesh_cells > 0 || has_rings(*state.water) ||
        state.water->surface.type == scene::WaterSurfaceType::mesh_sequence)
        return state;
    const scene::Extent& extent = state.water->extent;
    double widest = INFINITY;
    for (const scene::Light& light : state.lights) widest = std::min(widest, widest_beams(light, extent));
    const GridSize size = grid_size(*state.water);
    const double most = std::floor(std::sqrt(kDefaultTriangleCap / 2 * extent.size.x / extent.size.y));
    const double cells = std::min(std::round(extent.size.x / widest), most);
    if (!size.capped && cells > size.cells_x) state.water->mesh_cells = static_cast<int>(cells);
    return state;
}

}  // namespace dapple::ocean
