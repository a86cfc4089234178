#include "methods/reference/water_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dapple::reference {

double rounding_of(const glm::dvec3& position) {
    const glm::dvec3 size = glm::abs(position);
    return 0x1p-20 * (1 + std::max({size.x, size.y, size.z}));
}

double face_margin(const glm::dvec3& position) {
    return 2 * rounding_of(position);
}

rays::Ray float_ray(const glm::dvec3& origin, const glm::dvec3& direction, double near, float far) {
    rays::Ray ray;
    ray.origin = glm::vec3(origin);
    ray.direction = glm::vec3(direction);
    ray.near = static_cast<float>(near);
    ray.far = far;
    return ray;
}

WaterRays::WaterRays(const scene::FrameScene& scene) : scene_(scene) {
    if (scene.state.water) surface_.emplace(scene);
}

bool WaterRays::over_rectangle(const glm::dvec3& world) const {
    const scene::Extent& extent = scene_.state.water->extent;
    const glm::dvec2 offset = glm::abs(glm::dvec2(world.x, world.z) - extent.center);
    return offset.x <= 0.5 * extent.size.x && offset.y <= 0.5 * extent.size.y;
}

bool WaterRays::beyond_rectangle(const glm::dvec3& position) const {
    return surface_ && scene_.state.water->extent.kind == scene::ExtentKind::open_water &&
           !over_rectangle(position + scene_.origin);
}

bool WaterRays::in_water(const glm::dvec3& position) const {
    if (!surface_) return false;
    const glm::dvec3 world = position + scene_.origin;
    if (!over_rectangle(world))
        return scene_.state.water->extent.kind == scene::ExtentKind::open_water && world.y < 0;
    if (std::abs(world.y) > surface_->highest()) return world.y < 0;
    if (surface_->is_height_field()) {
        double height = 0, slope_x = 0, slope_z = 0;
        surface_->evaluate(std::span(&world.x, 1), std::span(&world.z, 1), std::span(&height, 1),
                           std::span(&slope_x, 1), std::span(&slope_z, 1));
        return world.y < height;
    }
    // The first surface overhead tells the side: under a sheet that is folded over there is air.
    const glm::dvec3 up(0, 1, 0);
    const rays::Ray ray = float_ray(position, up, 0, std::numeric_limits<float>::infinity());
    rays::Hit hit;
    rays_->intersect_water(std::span(&ray, 1), std::span(&hit, 1));
    return hit.primitive != rays::kNoHit && geometry_->water_point(hit, position, up).geometric_normal.y > 0;
}

void WaterRays::build() {
    fine_scene_ = scene_;
    fine_scene_->water = surface_->mesh();
    rays_.emplace(*fine_scene_);
    geometry_.emplace(*fine_scene_);
    chord_error_ = surface_->chord_error(*fine_scene_->water);
}

bool WaterRays::may_return(const glm::dvec3& direction) const {
    return std::abs(direction.y) <= surface_->steepest() * std::hypot(direction.x, direction.z);
}

double WaterRays::clear_of_water(const glm::dvec3& position, const glm::dvec3& direction,
                                 const glm::dvec3& normal) const {
    return (chord_error_ + rounding_of(position)) / std::max(1e-6, std::abs(dot(direction, normal)));
}

WaterCrossing WaterRays::crossing(const glm::dvec3& origin, const glm::dvec3& direction,
                                  const rays::Hit& hit) const {
    const view::SurfacePoint point = geometry_->water_point(hit, origin, direction);
    WaterCrossing crossing{point.distance, point.position, point.geometric_normal, point.shading_normal};
    if (!surface_->is_height_field()) return crossing;
    double distance = point.distance;
    double height = 0, slope_x = 0, slope_z = 0;
    for (int step = 0; step < 4; ++step) {
        const glm::dvec3 at = origin + distance * direction + scene_.origin;
        surface_->evaluate(std::span(&at.x, 1), std::span(&at.z, 1), std::span(&height, 1),
                           std::span(&slope_x, 1), std::span(&slope_z, 1));
        const double gap = at.y - height;
        const double rate = direction.y - slope_x * direction.x - slope_z * direction.z;
        // Rays that graze the surface cross the triangles but not it: the triangle's place is as good.
        if (std::abs(rate) < 1e-6 || std::abs(gap / rate) > 1e3 * (chord_error_ + rounding_of(origin)))
            return crossing;
        distance -= gap / rate;
    }
    crossing.distance = distance;
    crossing.position = origin + distance * direction;
    crossing.geometric_normal = crossing.shading_normal = normalize(glm::dvec3(-slope_x, 1, -slope_z));
    return crossing;
}

}  // namespace dapple::reference
