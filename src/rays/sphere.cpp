#include "rays/sphere.h"

#include <cmath>
#include <limits>

namespace dapple::rays {
namespace {

struct SphereHit {
    double distance;
    glm::dvec3 normal;
};

/// First crossing within (near, far]. The roots are taken about the point nearest to the centre, which keeps
/// the discriminant exact for rays from far away.
bool intersect(const Sphere& sphere, const glm::dvec3& origin, const glm::dvec3& direction, double near,
               double far, SphereHit& hit) {
    const glm::dvec3 o = sphere.unit_from_offset * (origin - sphere.center);
    const glm::dvec3 d = sphere.unit_from_offset * direction;
    const double d2 = dot(d, d);
    const double middle = -dot(o, d) / d2;
    const glm::dvec3 nearest = o + middle * d;
    const double square = 1 - dot(nearest, nearest);
    if (!(square >= 0)) return false;
    const double half_chord = std::sqrt(square / d2);
    hit.distance = middle - half_chord;
    if (!(hit.distance > near)) hit.distance = middle + half_chord;
    if (!(hit.distance > near && hit.distance <= far)) return false;
    hit.normal = transpose(sphere.unit_from_offset) * (o + hit.distance * d);
    return true;
}

bool intersect_lane(const Sphere& sphere, RTCRayN* ray, unsigned count, unsigned lane, SphereHit& hit) {
    const glm::dvec3 origin(RTCRayN_org_x(ray, count, lane), RTCRayN_org_y(ray, count, lane),
                            RTCRayN_org_z(ray, count, lane));
    const glm::dvec3 direction(RTCRayN_dir_x(ray, count, lane), RTCRayN_dir_y(ray, count, lane),
                               RTCRayN_dir_z(ray, count, lane));
    return intersect(sphere, origin, direction, RTCRayN_tnear(ray, count, lane),
                     RTCRayN_tfar(ray, count, lane), hit);
}

void on_intersect(const RTCIntersectFunctionNArguments* arguments) {
    const auto& sphere = *static_cast<const Sphere*>(arguments->geometryUserPtr);
    const unsigned count = arguments->N;
    RTCRayN* ray = RTCRayHitN_RayN(arguments->rayhit, count);
    RTCHitN* record = RTCRayHitN_HitN(arguments->rayhit, count);
    for (unsigned lane = 0; lane < count; ++lane) {
        SphereHit hit{};
        if (arguments->valid[lane] == 0 || !intersect_lane(sphere, ray, count, lane, hit)) continue;
        RTCRayN_tfar(ray, count, lane) = static_cast<float>(hit.distance);
        RTCHitN_Ng_x(record, count, lane) = static_cast<float>(hit.normal.x);
        RTCHitN_Ng_y(record, count, lane) = static_cast<float>(hit.normal.y);
        RTCHitN_Ng_z(record, count, lane) = static_cast<float>(hit.normal.z);
        RTCHitN_u(record, count, lane) = 0;
        RTCHitN_v(record, count, lane) = 0;
        RTCHitN_primID(record, count, lane) = arguments->primID;
        RTCHitN_geomID(record, count, lane) = arguments->geomID;
    }
}

void on_occluded(const RTCOccludedFunctionNArguments* arguments) {
    const auto& sphere = *static_cast<const Sphere*>(arguments->geometryUserPtr);
    for (unsigned lane = 0; lane < arguments->N; ++lane) {
        SphereHit hit{};
        if (arguments->valid[lane] == 0 || !intersect_lane(sphere, arguments->ray, arguments->N, lane, hit))
            continue;
        RTCRayN_tfar(arguments->ray, arguments->N, lane) = -std::numeric_limits<float>::infinity();
    }
}

/// The box of an ellipsoid reaches as far along an axis as that row of the matrix is long.
void on_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& sphere = *static_cast<const Sphere*>(arguments->geometryUserPtr);
    const glm::dmat3 rows = transpose(sphere.offset_from_unit);
    const auto widened = [&](int axis, double side) {
        const double bound = sphere.center[axis] + side * length(rows[axis]);
        const auto rounded = static_cast<float>(bound);
        return std::nextafter(rounded, static_cast<float>(side) * std::numeric_limits<float>::infinity());
    };
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = widened(0, -1);
    bounds.lower_y = widened(1, -1);
    bounds.lower_z = widened(2, -1);
    bounds.upper_x = widened(0, 1);
    bounds.upper_y = widened(1, 1);
    bounds.upper_z = widened(2, 1);
}

}  // namespace

RTCGeometry make_sphere_geometry(RTCDevice device, const Sphere& sphere) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    // Embree's interface has no const user data; nothing here writes to it.
    rtcSetGeometryUserData(geometry, const_cast<Sphere*>(&sphere));
    rtcSetGeometryBoundsFunction(geometry, on_bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, on_intersect);
    rtcSetGeometryOccludedFunction(geometry, on_occluded);
    return geometry;
}

}  // namespace dapple::rays
