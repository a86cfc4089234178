#include "view/camera_medium.h"

#include <cmath>
#include <limits>

#include "view/camera_paths.h"

namespace dapple::view {
namespace {

/// Twice the signed area of (a, b, c) seen along y: positive for triangles that face up.
double area_from_above(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.y - a.y) * (c.x - a.x) - (b.x - a.x) * (c.y - a.y);
}

}  // namespace

bool camera_in_water(const scene::FrameScene& scene) {
    return camera_medium(scene).in_water;
}

CameraMedium camera_medium(const scene::FrameScene& scene) {
    if (!scene.state.water) return {};
    const glm::dvec3 camera = scene.state.camera.position;
    const double margin = surface_margin(camera - scene.origin);
    const glm::dvec2 place(camera.x, camera.z);
    double nearest = std::numeric_limits<double>::infinity();
    bool below_water = false;
    bool covered = false;
    if (scene.water) {
        const scene::TriangleMesh& mesh = scene.water->mesh;
        for (const glm::uvec3& triangle : mesh.triangles) {
            const glm::dvec3& a = mesh.positions[triangle.x];
            const glm::dvec3& b = mesh.positions[triangle.y];
            const glm::dvec3& c = mesh.positions[triangle.z];
            const double opposite_a = area_from_above(place, {b.x, b.z}, {c.x, c.z});
            const double opposite_b = area_from_above({a.x, a.z}, place, {c.x, c.z});
            const double opposite_c = area_from_above({a.x, a.z}, {b.x, b.z}, place);
            const bool inside = (opposite_a >= 0 && opposite_b >= 0 && opposite_c >= 0) ||
                                (opposite_a <= 0 && opposite_b <= 0 && opposite_c <= 0);
            const double area = opposite_a + opposite_b + opposite_c;
            if (!inside || area == 0) continue;
            covered = true;
            const double height = (opposite_a * a.y + opposite_b * b.y + opposite_c * c.y) / area;
            if (height >= camera.y - margin && height < nearest) {
                nearest = height;
                below_water = area > 0;  // under a sheet that is folded over there is air
            }
        }
    }
    if (covered) return {below_water, nearest <= camera.y + margin};
    const bool open = scene.state.water->extent.kind == scene::ExtentKind::open_water;
    return {open && camera.y <= margin, open && std::abs(camera.y) <= margin};
}

bool point_in_water(const scene::FrameScene& scene, const rays::RayScene& rays, const glm::dvec3& point) {
    if (!scene.state.water) return false;
    rays::Ray ray{glm::vec3(point), 0, {0, 1, 0}};
    rays::Hit hit;
    rays.intersect_water({&ray, 1}, {&hit, 1});
    if (hit.primitive != rays::kNoHit) return hit.normal.y > 0;
    if (scene.state.water->extent.kind != scene::ExtentKind::open_water || point.y + scene.origin.y > 0)
        return false;
    ray.direction.y = -1;  // above the mesh, in the trough of a wave?
    rays.intersect_water({&ray, 1}, {&hit, 1});
    return hit.primitive == rays::kNoHit;
}

}  // namespace dapple::view
