#include "methods/photon_splatting/foreshortened_quad.h"

namespace dapple::methods {
namespace {

/// Derivatives by the place on the grid of where the light meets the water, of the water's normal there, and
/// of that of the mirror which sends it on, if one does.
struct SurfaceDifferentials {
    Vectors3 dx, dn, mirror_turn;
};

SurfaceDifferentials surface_differentials(const PhotonGrid& grid, const Photons& photons, GridAxis axis) {
    SurfaceDifferentials surface;
    surface.dx = photons.step_of(axis, [](const RayLanes& rays) { return rays.water; });
    surface.dn = photons.step_of(axis, [&](const RayLanes& rays) { return grid.normal(rays); });
    if (grid.mesh().mirrored())
        surface.mirror_turn =
            photons.step_of(axis, [&](const RayLanes& rays) { return grid.mirror_normal(rays); });
    return surface;
}

Floats triangle_area(Vectors3 a, Vectors3 b, Vectors3 c) {
    const Vectors3 twice = cross(b - a, c - a);
    return 0.5f * lanes::square_root<float>(dot(twice, twice));
}

}  // namespace

/// Photon differentials (Schjoth et al. 2007; Kougianos and Moustakas 2021, equations 8 to 10): the
/// derivatives of position and direction that the water's curvature gives the ray, carried to the plane.
Footprints differential_footprint(const PhotonGrid& grid, const Photons& photons, const PhotonHits& hits) {
    const auto side = [&](GridAxis axis, Vectors3& result) {
        const SurfaceDifferentials surface = surface_differentials(grid, photons, axis);
        Flags found = photons.any_connected(axis);
        const Vectors3 turned = grid.turned(photons, surface.dx, found);
        const Vectors3 spread = grid.spread(photons, turned, surface.dn, found);
        const Vectors3 step = grid.carried(photons, hits, {surface.dx, spread, surface.mirror_turn}, found);
        found &= finite(dot(step, step));  // not so at the critical angle
        result = choose(found, step, grid.parallel_step(photons, hits, axis));
        return found;
    };
    Footprints footprints;
    const Flags columns = side(GridAxis::columns, footprints.first);
    const Flags rows = side(GridAxis::rows, footprints.second);
    footprints.without_neighbors = ~(columns & rows);
    return footprints;
}

/// Kougianos and Moustakas 2021, equation 11 and algorithm 2 (which shows reflection only): the rays of the
/// next column and row at the photon's own distance, whose triangle gives the area of a square.
Footprints paper_differential_footprint(const PhotonGrid& grid, const Photons& photons,
                                        const PhotonHits& hits) {
    struct Corner {
        Vectors3 water, far;
    };
    const auto corner = [&](const RayLanes& ray) {
        return Corner{ray.surface, ray.surface + hits.way * normalized(ray.slope)};
    };
    const auto next = [&](GridAxis axis) {
        const Corner before = corner(photons.before(axis).ray), after = corner(photons.after(axis).ray);
        const Flags connected = photons.after(axis).connected;
        return Corner{choose(connected, after.water, before.water), choose(connected, after.far, before.far)};
    };
    const Corner own = corner(photons.own), right = next(GridAxis::columns), up = next(GridAxis::rows);
    const Flags alone = ~(photons.any_connected(GridAxis::columns) & photons.any_connected(GridAxis::rows));
    const Floats compression = triangle_area(own.far, right.far, up.far) /  // sigma^2, A' / A
                               triangle_area(own.water, right.water, up.water);
    Footprints footprints =
        foreshortened_quad(hits, (alone ? all(1.0f) : compression) * grid.cell_across_light(photons.own));
    footprints.without_neighbors = alone;
    return footprints;
}

}  // namespace dapple::methods
