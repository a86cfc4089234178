#pragma once
#include <glm/glm.hpp>

#include "view/path_starts.h"
#include "view/surface_point.h"

namespace dapple::view {

/// The sides that a path at a surface may use: geometric and shading normal towards the side it comes from,
/// the latter with its derivative.
struct FacingNormals {
    glm::dvec3 geometric;
    glm::dvec3 shading;
    glm::dmat3 shading_change;

    FacingNormals(const SurfacePoint& surface, const glm::dvec3& direction);
    /// Where an interpolated normal would send the path to the wrong side of the triangle.
    void fall_back_to_geometric();
};

/// What a smooth interface does to a path: directions and Fresnel's shares on both of its ways on. `eta` is
/// the index where the path comes from over that of the other side.
struct Crossing {
    FacingNormals normals;
    double eta;
    glm::dvec3 refracted{0};  ///< not normalised; means nothing where transmittance is 0
    glm::dvec3 reflected{0};  ///< not normalised
    double transmittance = 0;
    double reflectance = 1;

    Crossing(const glm::dvec3& direction, const SurfacePoint& surface, double eta);
    /// What radiance seen through the interface is multiplied by: it scales by n^2.
    double through() const { return transmittance * eta * eta; }
};

/// A rounding or more off the surface at `position`, on the side of `normal`: rays start there so as not to
/// meet it again.
glm::dvec3 lifted(const glm::dvec3& position, const glm::dvec3& normal);

/// Brings the path and its differentials to the surface.
void move_to(Path& path, const SurfacePoint& surface);
/// Turns a path that is at the interface, with its differentials and throughput.
void refract(Path& path, const Crossing& crossing);
void reflect(Path& path, const Crossing& crossing);
/// By a mirror; the throughput is the caller's.
void reflect(Path& path, const SurfacePoint& mirror);

}  // namespace dapple::view
