#include "methods/reference/glass_bodies.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "methods/reference/water_rays.h"
#include "rays/shape_mesh.h"
#include "scene/transform.h"

namespace dapple::reference {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Range {
    double low = kInfinity, high = -kInfinity;
    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

/// Range of a(x) / b(x) over an ellipsoid, a and b linear: values a0, b0 in the middle, and how they change
/// along the axes of the unit sphere. The extremes k are where the plane a - k b = 0 touches it,
/// (a0 - k b0)^2 = |a' - k b'|^2; b > 0 on all of it.
Range ratio_over_ellipsoid(double a0, const glm::dvec3& a, double b0, const glm::dvec3& b) {
    const double square = b0 * b0 - dot(b, b);
    const double middle = (a0 * b0 - dot(a, b)) / square;
    const double root = std::sqrt(std::max(0.0, middle * middle - (a0 * a0 - dot(a, a)) / square));
    return {middle - root, middle + root};
}

}  // namespace

GlassBodies::GlassBodies(const scene::FrameScene& scene)
    : scene_(scene), geometry_(scene), bodies_(scene), outlines_(scene.state.objects.size()) {
    for (std::size_t i = 0; i < outlines_.size(); ++i) {
        const scene::Object& object = scene.state.objects[i];
        if (!object.material.glass) continue;
        any_ = true;
        Outline& outline = outlines_[i];
        const glm::dmat4 placed = scene::relative_from_object(object.transform, scene.origin);
        if (object.shape == scene::Shape::sphere) {
            outline.sphere = true;
            outline.middle = glm::dvec3(placed[3]);
            outline.offset_from_unit = glm::dmat3(placed) * object.radius;
            outline.unit_from_offset = inverse(outline.offset_from_unit);
            const glm::dmat3& m = outline.offset_from_unit;
            outline.radius = std::max({length(m[0]), length(m[1]), length(m[2])});
            continue;
        }
        std::vector<glm::dvec3> positions;
        if (object.shape == scene::Shape::mesh) {
            if (i < scene.object_meshes.size() && scene.object_meshes[i])
                positions = scene.object_meshes[i]->positions;
        } else {
            positions = (object.shape == scene::Shape::box ? rays::box_mesh(object.size)
                                                           : rays::plane_mesh(object.size))
                            .positions;
        }
        if (positions.empty()) continue;
        glm::dvec3 low(kInfinity), high(-kInfinity);
        for (const glm::dvec3& position : positions) {
            const glm::dvec3 corner(placed * glm::dvec4(position, 1));
            low = glm::min(low, corner);
            high = glm::max(high, corner);
            outline.corners.push_back(corner);
        }
        outline.middle = 0.5 * (low + high);
        for (const glm::dvec3& corner : outline.corners)
            outline.radius = std::max(outline.radius, length(corner - outline.middle));
    }
}

bool GlassBodies::replace_water(const glm::dvec3& position, const glm::dvec3& normal) const {
    const glm::dvec3 off = face_margin(position) * normal;
    return bodies_.at(position - off) != view::kNoBody || bodies_.at(position + off) != view::kNoBody;
}

glm::dvec3 GlassBodies::through(std::uint32_t object, double distance) const {
    return glm::exp(-distance * scene_.state.objects[object].material.absorption);
}

view::SurfacePoint GlassBodies::point(const rays::Hit& hit, const glm::dvec3& origin,
                                      const glm::dvec3& direction, bool inside) const {
    const Outline& outline = outlines_[hit.object];
    if (!outline.sphere) return geometry_.object_point(hit, origin, direction);
    const glm::dvec3 o = outline.unit_from_offset * (origin - outline.middle);
    const glm::dvec3 d = outline.unit_from_offset * direction;
    const double d2 = dot(d, d);
    const double nearest = -dot(o, d) / d2;
    const glm::dvec3 away = o + nearest * d;
    // The ray that was traced is rounded: where this one misses by that much it touches.
    const double half_chord = std::sqrt(std::max(0.0, 1 - dot(away, away)) / d2);
    view::SurfacePoint point;
    point.distance = nearest + (inside ? half_chord : -half_chord);
    point.position = origin + point.distance * direction;
    point.geometric_normal = point.shading_normal =
        normalize(transpose(outline.unit_from_offset) * (o + point.distance * d));
    return point;
}

Rectangle GlassBodies::across(std::uint32_t object, const glm::dvec3& from, const glm::dvec3& u,
                              const glm::dvec3& v) const {
    const Outline& outline = outlines_[object];
    const auto range = [&](const glm::dvec3& axis) {
        const double middle = dot(outline.middle - from, axis);
        if (outline.sphere) {
            const double reach = length(transpose(outline.offset_from_unit) * axis);
            return Range{middle - reach, middle + reach};
        }
        Range result;
        for (const glm::dvec3& corner : outline.corners) result.add(dot(corner - from, axis));
        return result;
    };
    const Range x = range(u), y = range(v);
    return {{x.low, y.low}, {x.high, y.high}};
}

Rectangle GlassBodies::in_perspective(std::uint32_t object, const glm::dvec3& from, const glm::dvec3& u,
                                      const glm::dvec3& v, const glm::dvec3& w) const {
    const Outline& outline = outlines_[object];
    const auto range = [&](const glm::dvec3& axis) {
        if (outline.sphere) {
            const glm::dvec3 middle = outline.middle - from;
            const glm::dmat3 rows = transpose(outline.offset_from_unit);
            return ratio_over_ellipsoid(dot(middle, axis), rows * axis, dot(middle, w), rows * w);
        }
        Range result;
        for (const glm::dvec3& corner : outline.corners)
            result.add(dot(corner - from, axis) / dot(corner - from, w));
        return result;
    };
    const Range x = range(u), y = range(v);
    return {{x.low, y.low}, {x.high, y.high}};
}

}  // namespace dapple::reference
