#pragma once
#include <embree3/rtcore.h>

#include <glm/glm.hpp>

namespace dapple::rays {

/// A sphere under any invertible transform, as a user geometry of Embree: intersected in double, since its
/// own float sphere loses digits for small spheres far away and knows no ellipsoids.
struct Sphere {
    glm::dvec3 center;            ///< m, relative to the frame's origin
    glm::dmat3 unit_from_offset;  ///< from (position - center) to the unit sphere
    glm::dmat3 offset_from_unit;
};

/// A new geometry, not committed; `sphere` must outlive it.
RTCGeometry make_sphere_geometry(RTCDevice device, const Sphere& sphere);

}  // namespace dapple::rays
