#include "view/crossing.h"

#include <algorithm>
#include <utility>

#include "optics/optics.h"
#include "view/camera_medium.h"

namespace dapple::view {
namespace {

void reflect_about(Path& path, const FacingNormals& normals, const glm::dvec3& reflected) {
    path.direction_du = optics::f64::reflected_differential(
        path.direction, normals.shading, path.direction_du, normals.shading_change * path.origin_du);
    path.direction_dv = optics::f64::reflected_differential(
        path.direction, normals.shading, path.direction_dv, normals.shading_change * path.origin_dv);
    path.direction = normalize(reflected);
    path.start = lifted(path.origin, normals.geometric);
}

}  // namespace

FacingNormals::FacingNormals(const SurfacePoint& surface, const glm::dvec3& direction) {
    const double side = dot(direction, surface.geometric_normal) <= 0 ? 1 : -1;
    geometric = side * surface.geometric_normal;
    shading = side * surface.shading_normal;
    shading_change = side * surface.shading_normal_change;
}

void FacingNormals::fall_back_to_geometric() {
    shading = geometric;
    shading_change = glm::dmat3(0.0);
}

Crossing::Crossing(const glm::dvec3& direction, const SurfacePoint& surface, double eta_)
    : normals(surface, direction), eta(eta_) {
    bool transmits = optics::f64::refracted_direction(direction, normals.shading, eta, refracted);
    reflected = optics::f64::reflected_direction(direction, normals.shading);
    if (dot(direction, normals.shading) >= 0 || dot(reflected, normals.geometric) <= 0 ||
        (transmits && dot(refracted, normals.geometric) >= 0)) {
        normals.fall_back_to_geometric();
        transmits = optics::f64::refracted_direction(direction, normals.shading, eta, refracted);
        reflected = optics::f64::reflected_direction(direction, normals.shading);
    }
    if (!transmits) return;
    const double cos_i = std::min(1.0, -dot(direction, normals.shading));
    const double cos_t = optics::f64::transmitted_cosine(cos_i, eta);
    transmittance = optics::f64::fresnel_transmittance(cos_i, cos_t, eta);
    reflectance = optics::f64::fresnel_reflectance(cos_i, cos_t, eta);
}

glm::dvec3 lifted(const glm::dvec3& position, const glm::dvec3& normal) {
    return position + surface_margin(position) * normal;
}

void move_to(Path& path, const SurfacePoint& surface) {
    for (auto [dp, dd] :
         {std::pair{&path.origin_du, &path.direction_du}, {&path.origin_dv, &path.direction_dv}}) {
        *dp = optics::f64::transferred_differential(*dp, *dd, path.direction, surface.distance,
                                                    surface.geometric_normal);
    }
    path.length += surface.distance;
    path.origin = surface.position;
    path.left_rest_plane = false;
}

void refract(Path& path, const Crossing& crossing) {
    const FacingNormals& normals = crossing.normals;
    path.throughput *= crossing.through();
    path.direction_du =
        optics::f64::refracted_differential(path.direction, normals.shading, crossing.eta, path.direction_du,
                                            normals.shading_change * path.origin_du);
    path.direction_dv =
        optics::f64::refracted_differential(path.direction, normals.shading, crossing.eta, path.direction_dv,
                                            normals.shading_change * path.origin_dv);
    path.direction = normalize(crossing.refracted);
    path.start = lifted(path.origin, -normals.geometric);
}

void reflect(Path& path, const Crossing& crossing) {
    path.throughput *= crossing.reflectance;
    reflect_about(path, crossing.normals, crossing.reflected);
}

void reflect(Path& path, const SurfacePoint& mirror) {
    FacingNormals normals(mirror, path.direction);
    glm::dvec3 reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    if (dot(reflected, normals.geometric) <= 0) {
        normals.fall_back_to_geometric();
        reflected = optics::f64::reflected_direction(path.direction, normals.shading);
    }
    reflect_about(path, normals, reflected);
}

}  // namespace dapple::view
