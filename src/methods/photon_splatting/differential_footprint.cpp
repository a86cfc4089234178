#include <array>
#include <cmath>

#include "methods/photon_splatting/foreshortened_quad.h"
#include "optics/optics.h"

namespace dapple::methods {
namespace {

/// Derivatives by the place on the grid of where the light meets the water, and of the water's normal there.
bool surface_differential(const PhotonGrid& grid, std::size_t i, GridAxis axis, glm::vec3& dx,
                          glm::vec3& dn) {
    const Neighbors near = grid.neighbors(i, axis);
    const std::size_t from = near.has_before ? near.before : i, to = near.has_after ? near.after : i;
    const float steps = static_cast<float>((from != i ? 1 : 0) + (to != i ? 1 : 0));
    dx = (grid.surface_point(to) - grid.surface_point(from)) / steps;
    dn = (grid.normal(to) - grid.normal(from)) / steps;
    return near.any();
}

float triangle_area(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    return 0.5f * glm::length(glm::cross(b - a, c - a));
}

}  // namespace

/// Photon differentials (Schjoth et al. 2007; Kougianos and Moustakas 2021, equations 8 to 10): the
/// derivatives of position and direction that the water's curvature gives the ray, carried to the plane.
Footprint differential_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    const std::size_t i = hit.photon;
    const glm::vec3 incident = grid.incident(i), normal = grid.normal(i);
    const bool reflection = grid.mesh().event == light::Event::reflection;
    const auto side = [&](GridAxis axis, glm::vec3& result) {
        glm::vec3 dx, dn;
        if (surface_differential(grid, i, axis, dx, dn)) {
            const glm::vec3 turned = grid.sun() ? glm::vec3(0)
                                                : optics::f32::normalized_differential(
                                                      grid.surface_point(i) - grid.light_position(), dx);
            const glm::vec3 spread =
                reflection ? optics::f32::reflected_differential(incident, normal, turned, dn)
                           : optics::f32::refracted_differential(incident, normal, grid.eta(), turned, dn);
            result = optics::f32::transferred_differential(dx, spread, hit.beam, hit.way, hit.normal);
            if (std::isfinite(glm::dot(result, result))) return true;  // not so at the critical angle
        }
        result = grid.parallel_step(hit, axis);
        return false;
    };
    Footprint footprint;
    const bool columns = side(GridAxis::columns, footprint.first);
    const bool rows = side(GridAxis::rows, footprint.second);
    footprint.without_neighbors = !columns || !rows;
    return footprint;
}

/// Kougianos and Moustakas 2021, equation 11 and algorithm 2 (which shows reflection only): the rays of the
/// next column and row at the photon's own distance, whose triangle gives the area of a square.
Footprint paper_differential_footprint(const PhotonGrid& grid, const PhotonHit& hit) {
    const light::BeamMesh& mesh = grid.mesh();
    const std::size_t i = hit.photon;
    const Neighbors right = grid.neighbors(i, GridAxis::columns), up = grid.neighbors(i, GridAxis::rows);
    float compression = 1;  // sigma^2, A' / A
    const bool alone = !right.any() || !up.any();
    if (!alone) {
        const std::array<std::size_t, 3> corners = {i, right.has_after ? right.after : right.before,
                                                    up.has_after ? up.after : up.before};
        std::array<glm::vec3, 3> x, far;
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = grid.surface_point(corners[k]);
            far[k] = x[k] + hit.way * glm::normalize(mesh.slope[corners[k]]);
        }
        compression = triangle_area(far[0], far[1], far[2]) / triangle_area(x[0], x[1], x[2]);
    }
    Footprint footprint = foreshortened_quad(hit, compression * grid.cell_across_light(i));
    footprint.without_neighbors = alone;
    return footprint;
}

}  // namespace dapple::methods
